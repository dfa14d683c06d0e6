// Functions of mathematics whose results do not depend on the machine. A C library chooses among versions of these by
// what the CPU can do, and they differ in the last bit; a chaotic experiment then goes another way. These use +, -, *,
// / and square roots of doubles only, so they give the same bits wherever IEEE 754 is kept and nothing is contracted.
// Within 2 units in the last place; at most 1 for sin, cos, exp, log and pow.
#pragma once

namespace arkmesh::hal::fixed {

double sin(double x);
double cos(double x);
double tan(double x);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);
double sinh(double x);
double cosh(double x);
double tanh(double x);
double exp(double x);
double exp2(double x);
double log(double x);
double log2(double x);
double log10(double x);
double pow(double x, double y);
double cbrt(double x);
double hypot(double x, double y);

}  // namespace arkmesh::hal::fixed
