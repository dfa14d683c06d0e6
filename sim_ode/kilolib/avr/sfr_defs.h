/* What of the registers is no register. */
#include "io.h"
