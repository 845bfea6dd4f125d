#include "fracture/triangulate.h"
