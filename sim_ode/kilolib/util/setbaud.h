/* The serial line's divisor for BAUD, as the robot's C library has it; may be included again for another one. */
#ifndef BAUD
#error "util/setbaud.h: define BAUD before it is included"
#endif
#ifndef BAUD_TOL
#define BAUD_TOL 2
#endif
#undef UBRR_VALUE
#undef UBRRL_VALUE
#undef UBRRH_VALUE
#undef USE_2X
/* Sixteen samples a bit, unless the rate then is off by more than BAUD_TOL percent; then eight. */
#define UBRR_VALUE (((F_CPU) + 8UL * (BAUD)) / (16UL * (BAUD)) - 1UL)
#if 100 * (F_CPU) > (16 * (UBRR_VALUE + 1)) * (100 * (BAUD) + (BAUD) * (BAUD_TOL)) || \
    100 * (F_CPU) < (16 * (UBRR_VALUE + 1)) * (100 * (BAUD) - (BAUD) * (BAUD_TOL))
#undef UBRR_VALUE
#define UBRR_VALUE (((F_CPU) + 4UL * (BAUD)) / (8UL * (BAUD)) - 1UL)
#define USE_2X 1
#else
#define USE_2X 0
#endif
#define UBRRL_VALUE (UBRR_VALUE & 0xff)
#define UBRRH_VALUE (UBRR_VALUE >> 8)
