#include "fracture/certificate.h"
