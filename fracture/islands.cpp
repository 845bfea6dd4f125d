#include "fracture/islands.h"
