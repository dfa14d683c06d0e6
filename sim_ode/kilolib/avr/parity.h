/* The former name. */
#include <util/parity.h>
