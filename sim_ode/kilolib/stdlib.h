/* The C library's own, strictly the standard's part of it, and what the robot's library has beyond that. */
#include_next <stdlib.h>
#undef RAND_MAX
#define RAND_MAX 0x7FFF
#ifndef ARKMESH_STDLIB_H
#define ARKMESH_STDLIB_H
#include <stdint.h>
#define RANDOM_MAX 0x7FFFFFFF
#define DTOSTR_ALWAYS_SIGN 1
#define DTOSTR_PLUS_SIGN 2
#define DTOSTR_UPPERCASE 4
long random(void);
void srandom(unsigned seed);
/* of a robot's unsigned long */
int rand_r(uint32_t* state);
long random_r(uint32_t* state);
char* itoa(int value, char* text, int radix);
char* ltoa(long value, char* text, int radix);
char* utoa(unsigned value, char* text, int radix);
char* ultoa(unsigned long value, char* text, int radix);
char* dtostrf(double value, signed char width, unsigned char precision, char* text);
char* dtostre(double value, char* text, unsigned char precision, unsigned char flags);
#endif
