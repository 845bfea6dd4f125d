#include "fracture/fracture.h"
