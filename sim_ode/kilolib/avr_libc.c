/* The robot's C library where it differs from the host's, linked into each program: own rand, printf, exit and strtok,
   because the host's would be shared by all robots, and what it has beyond the standard. */
#include <ctype.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "robot_parts.h"

ROBOT static uint8_t serial_line = 0;
ROBOT static char* strtok_rest = 0;
ROBOT static int32_t rand_state = 1;
ROBOT static int32_t random_state = 1;

/* ---- numbers as text ---- */

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

/* ---- chance ---- */

/* Park and Miller's generator, as in the robot's C library; rand() cuts it to 15 bits. */
static int32_t next_random(int32_t* state) {
  int64_t x = *state == 0 ? 123459876 : *state;
  *state = (int32_t)(x * 16807 % 0x7FFFFFFF);
  return *state;
}
STAND_IN int rand(void) {
  SPEND(60);
  return next_random(&rand_state) % 0x8000;
}
STAND_IN void srand(unsigned seed) {
  rand_state = (uint16_t)seed;
}
STAND_IN int rand_r(unsigned long* state) {
  int32_t x = (int32_t)*state;
  const int value = next_random(&x) % 0x8000;
  *state = (unsigned long)x;
  return value;
}
STAND_IN long random(void) {
  SPEND(60);
  return next_random(&random_state);
}
STAND_IN void srandom(unsigned seed) {
  random_state = (int32_t)seed;
}
STAND_IN long random_r(unsigned long* state) {
  int32_t x = (int32_t)*state;
  next_random(&x);
  *state = (unsigned long)x;
  return x;
}

/* ---- ends ---- */

/* What would end the simulator's process, or take its signals from it. Each is called by the program itself, for its
   line: equal ones are not made one that calls another. */
#define ENDS(name, function)                            \
  STAND_IN __attribute__((noreturn, no_icf)) function { \
    arkmesh_calls.ended("called " name "()", CALLER);   \
    __builtin_unreachable();                            \
  }
ENDS("exit", void exit(int status))
ENDS("_exit", void _exit(int status))
ENDS("_Exit", void _Exit(int status))
ENDS("quick_exit", void quick_exit(int status))
ENDS("abort", void abort(void))
ENDS("raise", int raise(int number))
ENDS("kill", int kill(int process, int number))
ENDS("signal", void* signal(int number, void* handler))
ENDS("signal", void* __sysv_signal(int number, void* handler)) /* as the PC's headers have it */
ENDS("sigaction", int sigaction(int number, const void* action, void* before))
/* Out of an interrupt nobody jumps: it may have come while loop waits on another stack. */
__attribute__((noreturn)) void siglongjmp(struct __jmp_buf_tag* place, int value); /* hidden by __STRICT_ANSI__ */
STAND_IN __attribute__((noreturn)) void longjmp(struct __jmp_buf_tag* place, int value) {
  arkmesh_calls.jumps(CALLER);
  siglongjmp(place, value);
}
STAND_IN __attribute__((noreturn)) void __assert_fail(const char* what, const char* file, unsigned line,
                                                      const char* function) {
  char why[160];
  (void)function;
  snprintf(why, sizeof why, "failed the assertion %s at %s:%u", what, file, line);
  arkmesh_calls.ended(why, CALLER);
  __builtin_unreachable();
}

/* ---- text ---- */

/* The serial line is on: 38400 baud, and whoever prints waits until the last character has left. */
void arkmesh_serial_on(void) {
  serial_line = 1;
}

static int say(const char* format, va_list values, const char* from) {
  char line[400];
  const int size = vsnprintf(line, sizeof line, format, values);
  if (size <= 0) return size;
  if (arkmesh_calls.text) arkmesh_calls.text(line, size < (int)sizeof line ? (uint32_t)size : sizeof line - 1);
  if (serial_line)
    arkmesh_calls.wait_us((uint32_t)size * 260, 0);
  else if ((arkmesh_work += 50 * (uint32_t)size) >= work_per_tick)
    arkmesh_give_time(from);
  return size;
}
static int say_words(const char* from, const char* format, ...) {
  va_list values;
  int size;
  va_start(values, format);
  size = say(format, values, from);
  va_end(values);
  return size;
}
#define SAY(format)                   \
  va_list values;                     \
  int size;                           \
  va_start(values, format);           \
  size = say(format, values, CALLER); \
  va_end(values);                     \
  return size;
STAND_IN int vprintf(const char* format, va_list values) {
  return say(format, values, CALLER);
}
STAND_IN int printf(const char* format, ...){SAY(format)} STAND_IN int puts(const char* text) {
  return say_words(CALLER, "%s\n", text);
}
STAND_IN int putchar(int c) {
  say_words(CALLER, "%c", c);
  return c;
}
/* A robot has one place for text only, whatever the stream. */
STAND_IN int vfprintf(FILE* stream, const char* format, va_list values) {
  (void)stream;
  return say(format, values, CALLER);
}
STAND_IN int fprintf(FILE* stream, const char* format, ...) {
  (void)stream;
  SAY(format)
}
STAND_IN int fputs(const char* text, FILE* stream) {
  (void)stream;
  return say_words(CALLER, "%s", text);
}
STAND_IN int fputc(int c, FILE* stream) {
  (void)stream;
  say_words(CALLER, "%c", c);
  return c;
}
STAND_IN int putc(int c, FILE* stream) {
  (void)stream;
  say_words(CALLER, "%c", c);
  return c;
}
STAND_IN size_t fwrite(const void* from, size_t size, size_t count, FILE* stream) {
  (void)stream;
  say_words(CALLER, "%.*s", (int)(size * count), (const char*)from);
  return count;
}
STAND_IN int fflush(FILE* stream) {
  (void)stream;
  return 0;
}
STAND_IN char* strtok(char* text, const char* separators) {
  char* begin = text ? text : strtok_rest;
  if (!begin) return 0;
  begin += strspn(begin, separators);
  char* end = begin + strcspn(begin, separators);
  strtok_rest = *end ? end + 1 : 0;
  *end = 0;
  return *begin || end > begin ? begin : 0;
}
