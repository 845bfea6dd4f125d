#include "fracture/io/atomic_file.h"
