/* Busy waits of the robot's C library: three and four cycles of 8 MHz a round. */
#ifndef ARKMESH_UTIL_DELAY_BASIC_H
#define ARKMESH_UTIL_DELAY_BASIC_H
#include "delay.h"
static inline void _delay_loop_1(uint8_t rounds) {
  arkmesh_wait_us((rounds ? rounds : 256u) * 3 / 8);
}
static inline void _delay_loop_2(uint16_t rounds) {
  arkmesh_wait_us((rounds ? rounds : 65536u) / 2);
}
#endif
