#include "fracture/sequential.h"
