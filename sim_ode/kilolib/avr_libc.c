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

/* No files, but places that a program may set; the simulator knows them for the serial line. */
__attribute__((section(".arkmesh_host")))
FILE* arkmesh_serial[3] = {(FILE*)&serial_line, (FILE*)&serial_line, (FILE*)&serial_line};

/* ---- numbers as text ---- */

STAND_IN char* strrev(char* text) {
  char *begin = text, *end = text + strlen(text);
  for (; begin < --end; begin++) {
    const char swapped = *begin;
    *begin = *end;
    *end = swapped;
  }
  return text;
}
static char* digits(unsigned long long value, int minus, char* text, int radix) {
  char* end = text;
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
  return strrev(text);
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
  return digits((uint16_t)value, 0, text, radix);
}
STAND_IN char* ultoa(unsigned long value, char* text, int radix) {
  return digits((uint32_t)value, 0, text, radix);
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
STAND_IN int rand_r(uint32_t* state) {
  int32_t x = (int32_t)*state;
  const int value = next_random(&x) % 0x8000;
  *state = (uint32_t)x;
  return value;
}
STAND_IN long random(void) {
  SPEND(60);
  return next_random(&random_state);
}
STAND_IN void srandom(unsigned seed) {
  random_state = (int32_t)seed;
}
STAND_IN long random_r(uint32_t* state) {
  int32_t x = (int32_t)*state;
  next_random(&x);
  *state = (uint32_t)x;
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

/* ---- memory ---- */

STAND_IN void* malloc(size_t size) {
  SPEND(40);
  return arkmesh_calls.reallocate(0, size ? size : 1, CALLER);
}
STAND_IN void* calloc(size_t count, size_t size) {
  size_t bytes;
  void* out;
  SPEND(40);
  if (__builtin_mul_overflow(count, size, &bytes)) return 0;
  out = arkmesh_calls.reallocate(0, bytes ? bytes : 1, CALLER);
  if (out) memset(out, 0, bytes);
  return out;
}
STAND_IN void* realloc(void* old, size_t size) {
  SPEND(40);
  return arkmesh_calls.reallocate(old, size ? size : 1, CALLER);
}
STAND_IN void free(void* old) {
  SPEND(40);
  if (old) arkmesh_calls.reallocate(old, 0, CALLER);
}
STAND_IN char* strdup(const char* text) {
  const size_t size = strlen(text) + 1;
  char* out = arkmesh_calls.reallocate(0, size, CALLER);
  return out ? memcpy(out, text, size) : out;
}

/* What a program's function returns: of the int that the program was compiled with. */
#ifdef ARKMESH_PC_TYPES
typedef int (*compare_t)(const void*, const void*);
#else
typedef int16_t (*compare_t)(const void*, const void*);
#endif
STAND_IN void qsort(void* from, size_t count, size_t size, int (*order)(const void*, const void*)) {
  const compare_t compare = (compare_t)order;
  char *const begin = from, *const end = begin + count * size, *next, *at, *a, *b;
  for (next = begin + size; next < end; next += size)
    for (at = next; at > begin && compare(at - size, at) > 0; at -= size)
      for (a = at - size, b = at; a < at; a++, b++) {
        const char swapped = *a;
        *a = *b;
        *b = swapped;
      }
}
STAND_IN void* bsearch(const void* key, const void* from, size_t count, size_t size,
                       int (*order)(const void*, const void*)) {
  const char* begin = from;
  while (count > 0) {
    const char* const middle = begin + count / 2 * size;
    const int way = ((compare_t)order)(key, middle);
    if (way == 0) return (void*)middle;
    if (way > 0) begin = middle + size;
    count = way > 0 ? count - count / 2 - 1 : count / 2;
  }
  return 0;
}

/* ---- text ---- */

/* The serial line is on: 38400 baud, and whoever prints waits until the last character has left. */
void arkmesh_serial_on(void) {
  serial_line = 1;
}

/* Formats for the C library: a robot's long is an int of 32 bits there, and what is read into its int goes into a
   short. */
enum { longest_format = 400 };
static const char* with_our_widths(const char* format, char* room, int reads) {
#ifndef ARKMESH_PC_TYPES
  const char* at = format;
  char* to = room;
  while (*at) {
    if (to > room + longest_format - 12) return format;
    if ((*to++ = *at++) != '%') continue;
    while (*at && strchr("-+ #0123456789.*", *at) && to < room + longest_format - 4) *to++ = *at++;
    if (*at == 'l' && at[1] != 'l')
      at++;
    else if (reads && *at && strchr("dioxXun", *at))
      *to++ = 'h';
    if (*at) *to++ = *at++;
  }
  *to = 0;
  format = room;
#endif
  (void)room, (void)reads;
  return format;
}

static int say(FILE* stream, const char* format, va_list values, const char* from) {
  char line[400], room[longest_format];
  va_list again;
  int size;
  format = with_our_widths(format, room, 0);
  if (stream) {
    va_copy(again, values);
    size = arkmesh_calls.print(stream, format, again);
    va_end(again);
    if (size >= 0) return size;
  }
  size = arkmesh_calls.format(line, sizeof line, format, values);
  if (size <= 0) return size;
  arkmesh_calls.text(line, size < (int)sizeof line ? (uint32_t)size : sizeof line - 1);
  if (serial_line)
    arkmesh_calls.wait_us((uint32_t)size * 260, 0);
  else if ((arkmesh_work += 50 * (uint32_t)size) >= work_per_tick)
    arkmesh_give_time(from);
  return size;
}
static int say_words(FILE* stream, const char* from, const char* format, ...) {
  va_list values;
  int size;
  va_start(values, format);
  size = say(stream, format, values, from);
  va_end(values);
  return size;
}
#define WITH_VALUES(function, result) \
  STAND_IN function {                 \
    va_list values;                   \
    char room[longest_format];        \
    int size;                         \
    (void)room;                       \
    va_start(values, format);         \
    size = result;                    \
    va_end(values);                   \
    return size;                      \
  }
STAND_IN int vprintf(const char* format, va_list values) {
  return say(0, format, values, CALLER);
}
WITH_VALUES(int printf(const char* format, ...), say(0, format, values, CALLER))
STAND_IN int puts(const char* text) {
  return say_words(0, CALLER, "%s\n", text);
}
STAND_IN int putchar(int c) {
  say_words(0, CALLER, "%c", c);
  return c;
}
STAND_IN int vfprintf(FILE* stream, const char* format, va_list values) {
  return say(stream, format, values, CALLER);
}
WITH_VALUES(int fprintf(FILE* stream, const char* format, ...), say(stream, format, values, CALLER))
STAND_IN int fputs(const char* text, FILE* stream) {
  return say_words(stream, CALLER, "%s", text);
}
STAND_IN int fputc(int c, FILE* stream) {
  say_words(stream, CALLER, "%c", c);
  return c;
}
STAND_IN int putc(int c, FILE* stream) {
  say_words(stream, CALLER, "%c", c);
  return c;
}
STAND_IN size_t fwrite(const void* from, size_t size, size_t count, FILE* stream) {
  if (arkmesh_calls.write(stream, from, size * count) < 0)
    say_words(0, CALLER, "%.*s", (int)(size * count), (const char*)from);
  return count;
}
STAND_IN int fflush(FILE* stream) {
  if (stream) arkmesh_calls.write(stream, 0, 0);
  return 0;
}
STAND_IN FILE* fopen(const char* name, const char* mode) {
  SPEND(100);
  return arkmesh_calls.open(name, mode);
}
STAND_IN int fclose(FILE* stream) {
  return arkmesh_calls.close(stream);
}
STAND_IN int vsnprintf(char* to, size_t size_of_to, const char* format, va_list values) {
  char room[longest_format];
  return arkmesh_calls.format(to, size_of_to, with_our_widths(format, room, 0), values);
}
STAND_IN int vsprintf(char* to, const char* format, va_list values) {
  return vsnprintf(to, INT32_MAX, format, values);
}
WITH_VALUES(int snprintf(char* to, size_t size_of_to, const char* format, ...),
            vsnprintf(to, size_of_to, format, values))
WITH_VALUES(int sprintf(char* to, const char* format, ...), vsnprintf(to, INT32_MAX, format, values))
WITH_VALUES(int sscanf(const char* text, const char* format, ...),
            arkmesh_calls.scan(text, with_our_widths(format, room, 1), values))
WITH_VALUES(int fscanf(FILE* stream, const char* format, ...),
            arkmesh_calls.scan_file(stream, with_our_widths(format, room, 1), values))
STAND_IN char* strtok(char* text, const char* separators) {
  char* begin = text ? text : strtok_rest;
  if (!begin) return 0;
  begin += strspn(begin, separators);
  char* end = begin + strcspn(begin, separators);
  strtok_rest = *end ? end + 1 : 0;
  *end = 0;
  return *begin || end > begin ? begin : 0;
}
