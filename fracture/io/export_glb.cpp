#include "fracture/io/export_glb.h"
