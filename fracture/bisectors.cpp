#include "fracture/bisectors.h"
