#include "fracture/clip.h"
