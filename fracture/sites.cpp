#include "fracture/sites.h"
