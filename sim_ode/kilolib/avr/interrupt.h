/* A simulated robot's interrupts never come between two statements of its program, and all belong to its library. */
#ifndef ARKMESH_AVR_INTERRUPT_H
#define ARKMESH_AVR_INTERRUPT_H
#include "io.h"
#define cli() ((void)0)
#define sei() ((void)0)
#define reti() return
#define ISR(vector, ...)                                                           \
  _Static_assert(0, "a simulated robot has no interrupts for programs: " #vector); \
  static void arkmesh_isr_##vector(void)
#define SIGNAL(vector) ISR(vector)
#endif
