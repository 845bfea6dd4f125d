#include "fracture/normals.h"
