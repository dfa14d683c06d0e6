/* Whether a byte has an odd number of ones. */
#ifndef ARKMESH_UTIL_PARITY_H
#define ARKMESH_UTIL_PARITY_H
#define parity_even_bit(value) __builtin_parity((unsigned char)(value))
#endif
