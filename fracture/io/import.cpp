#include "fracture/io/import.h"
