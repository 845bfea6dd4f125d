#include "fracture/topology.h"
