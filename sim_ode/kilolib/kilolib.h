/* The public Kilobot library as robots' programs see it, for programs that run in the simulator. Takes no name that the
   library on a robot does not take, apart from names that begin with arkmesh_. */
#ifndef __KILOLIB_H__
#define __KILOLIB_H__

#include <stddef.h>
#include <stdint.h>
/* A robot's long, which suffix L makes, has 32 bits. */
#undef INT64_C
#undef UINT64_C
#define INT64_C(c) c##LL
#define UINT64_C(c) c##ULL

#include "message.h"
#include "message_crc.h"

/* Red, green, blue: 0..3 each. Without outer parentheses, as on the robot. */
#define RGB(r, g, b) (r & 3) | (((g & 3) << 2)) | ((b & 3) << 4)
#define TICKS_PER_SEC 31

/* Strength of a received message, 10 bits each; low first. */
typedef struct {
  int16_t low_gain;
  int16_t high_gain;
} distance_measurement_t;

typedef void (*message_rx_t)(message_t*, distance_measurement_t* d);
typedef message_t* (*message_tx_t)(void);
typedef void (*message_tx_success_t)(void);

/* Not for programs to replace: without this they would go through the global offset table. */
#pragma GCC visibility push(hidden)

extern volatile uint32_t arkmesh_ticks;
extern uint32_t arkmesh_reads;
void arkmesh_busy(void);

/* A program that waits by reading the clock is put to sleep until the next tick. */
static inline volatile uint32_t* arkmesh_clock(void) {
  if (++arkmesh_reads >= 400) arkmesh_busy();
  return &arkmesh_ticks;
}
/* Ticks of 32.768 ms since power-up; may be assigned. A variable only for programs that do not compile with the macro.
 */
#ifdef ARKMESH_PLAIN_CLOCK
extern volatile uint32_t kilo_ticks __asm__("arkmesh_ticks");
#else
#define kilo_ticks (*arkmesh_clock())
#endif

extern volatile uint16_t kilo_tx_period;
extern uint16_t kilo_uid;
extern uint8_t kilo_turn_left;
extern uint8_t kilo_turn_right;
extern uint8_t kilo_straight_left;
extern uint8_t kilo_straight_right;
extern uint16_t kilo_irhigh[14];
extern uint16_t kilo_irlow[14];

extern message_rx_t kilo_message_rx;
extern message_tx_t kilo_message_tx;
extern message_tx_success_t kilo_message_tx_success;

void kilo_init();
void kilo_start(void (*setup)(void), void (*loop)(void));
void delay(uint16_t ms);
void set_motors(uint8_t left, uint8_t right);
void spinup_motors();
void set_color(uint8_t color);
uint8_t estimate_distance(const distance_measurement_t* dist);
int16_t get_ambientlight();
int16_t get_voltage();
int16_t get_temperature();
uint8_t rand_hard();
uint8_t rand_soft();
void rand_seed(uint8_t seed);
/* Programs call these without stdlib.h: on a robot a pointer fits into the int that is taken for their result. */
void* malloc(size_t size);
void* calloc(size_t count, size_t size);
void* realloc(void* old, size_t size);
void free(void* block);

#pragma GCC visibility pop

#endif
