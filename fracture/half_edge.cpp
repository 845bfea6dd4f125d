#include "fracture/half_edge.h"
