#include "fracture/shapes.h"
