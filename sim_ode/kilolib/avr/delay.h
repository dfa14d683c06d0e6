/* The former name. */
#include <util/delay.h>
