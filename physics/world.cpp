#include "physics/world.h"
