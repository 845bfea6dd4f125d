#include "fracture/mass_properties.h"
