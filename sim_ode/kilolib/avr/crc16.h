/* The former name. */
#include <util/crc16.h>
