/* What the robot's C library has and the host's has not, or only beyond the standard: linked into each program. */
#include <ctype.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* Stands in for the C library's unless the program has its own. */
#define STAND_IN __attribute__((visibility("hidden"), weak))

static char* digits(unsigned long long value, int minus, char* text, int radix) {
  char *end = text, *begin;
  if (radix < 2 || radix > 36) {
    *text = 0;
    return text;
  }
  do {
    *end++ = "0123456789abcdefghijklmnopqrstuvwxyz"[value % (unsigned)radix];
    value /= (unsigned)radix;
  } while (value);
  if (minus) *end++ = '-';
  *end = 0;
  for (begin = text; begin < --end; begin++) {
    const char swapped = *begin;
    *begin = *end;
    *end = swapped;
  }
  return text;
}
STAND_IN char* itoa(int value, char* text, int radix) {
  const int minus = radix == 10 && value < 0;
  return digits(minus         ? 0u - (unsigned)value
                : radix == 10 ? (unsigned)value
                              : (unsigned)value & 0xFFFF,
                minus, text, radix);
}
STAND_IN char* ltoa(long value, char* text, int radix) {
  const int minus = radix == 10 && value < 0;
  return digits(minus         ? 0ul - (unsigned long)value
                : radix == 10 ? (unsigned long)value
                              : (uint32_t)value,
                minus, text, radix);
}
STAND_IN char* utoa(unsigned value, char* text, int radix) {
  return digits(value, 0, text, radix);
}
STAND_IN char* ultoa(unsigned long value, char* text, int radix) {
  return digits(value, 0, text, radix);
}
STAND_IN char* dtostrf(double value, signed char width, unsigned char precision, char* text) {
  sprintf(text, "%*.*f", width, precision, value);
  return text;
}
STAND_IN char* dtostre(double value, char* text, unsigned char precision, unsigned char flags) {
  sprintf(text, flags & 4 ? "%.*E" : "%.*e", precision, value);
  return text;
}
STAND_IN double square(double x) {
  return x * x;
}
STAND_IN size_t strlcpy(char* to, const char* from, size_t room) {
  const size_t size = strlen(from);
  if (room > 0) {
    const size_t kept = size < room ? size : room - 1;
    memcpy(to, from, kept);
    to[kept] = 0;
  }
  return size;
}
STAND_IN size_t strlcat(char* to, const char* from, size_t room) {
  size_t size = 0;
  while (size < room && to[size]) size++;
  return size + strlcpy(to + size, from, room - size);
}
STAND_IN char* strrev(char* text) {
  char *begin = text, *end = text + strlen(text);
  for (; begin < --end; begin++) {
    const char swapped = *begin;
    *begin = *end;
    *end = swapped;
  }
  return text;
}
STAND_IN char* strupr(char* text) {
  char* at;
  for (at = text; *at; at++) *at = (char)toupper((unsigned char)*at);
  return text;
}
STAND_IN char* strlwr(char* text) {
  char* at;
  for (at = text; *at; at++) *at = (char)tolower((unsigned char)*at);
  return text;
}
