/* The C library's own, strictly the standard's part of it (so that y0 or gamma are free), and the constants of the
 * robot's library. */
#include_next <math.h>
#ifndef ARKMESH_MATH_H
#define ARKMESH_MATH_H
#define M_E 2.7182818284590452354
#define M_LOG2E 1.4426950408889634074
#define M_LOG10E 0.43429448190325182765
#define M_LN2 0.69314718055994530942
#define M_LN10 2.30258509299404568402
#define M_PI 3.14159265358979323846
#define M_PI_2 1.57079632679489661923
#define M_PI_4 0.78539816339744830962
#define M_1_PI 0.31830988618379067154
#define M_2_PI 0.63661977236758134308
#define M_2_SQRTPI 1.12837916709551257390
#define M_SQRT2 1.41421356237309504880
#define M_SQRT1_2 0.70710678118654752440
double square(double x);
#ifndef ARKMESH_PC_TYPES
/* A robot's double is float, its int our short. */
static inline float arkmesh_frexp(float x, short* exponent) {
  int whole;
  x = frexpf(x, &whole);
  *exponent = (short)whole;
  return x;
}
#define frexp(x, exponent) arkmesh_frexp(x, exponent)
#define modf(x, whole) modff(x, whole)
#endif
#endif
