#include "fracture/io/weld.h"
