/* Busy waits of the robot's C library. */
#ifndef ARKMESH_UTIL_DELAY_H
#define ARKMESH_UTIL_DELAY_H
#include <stdint.h>
#pragma GCC visibility push(hidden)
void arkmesh_wait_us(uint32_t us);
#pragma GCC visibility pop
static inline void _delay_ms(double ms) {
  arkmesh_wait_us((uint32_t)(ms * 1000));
}
static inline void _delay_us(double us) {
  arkmesh_wait_us((uint32_t)us);
}
#endif
