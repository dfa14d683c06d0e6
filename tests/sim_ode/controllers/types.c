/* Green where all is as with a robot's types; otherwise the LED shows which is not. */
#include "kilolib.h"
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  unsigned a;
  long int b;
  unsigned const long c;
  short int d;
  double e;
  long long f;
} fields_t;

static int sum(int count, ...) {
  va_list values;
  int out = 0;
  va_start(values, count);
  while (count--) out += va_arg(values, int);
  out += (int)va_arg(values, double) + (int)va_arg(values, long);
  va_end(values);
  return out;
}
static int by_size(const void* a, const void* b) {
  return *(const int*)a - *(const int*)b;
}
static int old(a, b) int a;
long b;
{ return a + (int)b; }

static int wrong(void) {
  int id = 0xFF << 8 | 0xFE, sorted[5] = {3, -2, 300, 0, 7}, key = 300, read = 0, next = 5;
  unsigned wraps = 65535;
  long far, before = (long)(uint32_t)(3u - 5u);
  unsigned long product = 100000UL;
  char text[30];
  double whole, third = 1.0 / 3;
  wraps++;
  if (id >= 0 || id != -2) return 1;
  if (wraps != 0 || sizeof(int) != 2 || sizeof(unsigned) != 2 || sizeof(long) != 4 || sizeof(double) != 4) return 2;
  if (sizeof(fields_t) != 2 + 4 + 4 + 2 + 4 + 8) return 3;
  if ((uint32_t)(90 * 0.7) != 63 || third != 1.0f / 3) return 4;
  if (before != -2 || product * 100000UL / 100000UL == 100000) return 5;
  if (sum(3, 1, 2, 3, 4.0, 5L) != 15 || old(1, 2L) != 3) return 6;
  if (INT_MAX != 32767 || UINT_MAX != 65535u || LONG_MAX != 2147483647 || DBL_MAX != FLT_MAX) return 7;
  qsort(sorted, 5, sizeof sorted[0], by_size);
  if (sorted[0] != -2 || sorted[4] != 300 || !bsearch(&key, sorted, 5, sizeof key, by_size)) return 8;
  far = -70000;
  snprintf(text, sizeof text, "%ld %d %lu", far, id, product);
  if (strcmp(text, "-70000 -2 100000")) return 9;
  if (sscanf("12 -70001 2.5", "%d %ld %lf", &read, &far, &third) != 3 || next != 5) return 10;
  if (read != 12 || far != -70001 || third != 2.5) return 11;
  if (modf(2.25, &whole) != 0.25 || whole != 2 || frexp(8.0, &read) != 0.5 || read != 4) return 12;
  if (INT64_C(1) << 40 == 0 || 0x7fffffffL != 2147483647 || strlen("int long double \" unsigned") != 26) return 13;
  return 0;
}
static void setup(void) {
  const int what = wrong();
  printf("%d\n", what);
  set_color(what == 0 ? RGB(0, 1, 0) : RGB(1, 0, 0));
}
static void loop(void) {}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
