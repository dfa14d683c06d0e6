/* The Kilobot library for the robot's own processor in an emulator: every call asks emulator.c, which answers from a
   log of what happened to a simulated robot. What comes next is the emulator's matter, so nothing waits for real time.
   Also what programs are linked with to be measured; not for robots. */
#include "kilolib.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdio.h>
#include <stdlib.h>
#undef kilo_ticks
#undef printf
#define ROBOT
#define SPEND(amount)

/* Addresses that no register has. A write to the first is a call; its answer is there when the write is done. */
#define CALL (*(volatile char*)0xE0)
#define NEXT (*(volatile char*)0xE1) /* 0, or 'w': something else comes first */
#define VALUE (*(volatile uint32_t*)0xE2)
#define FROM (*(volatile uint16_t*)0xE6)

volatile uint32_t kilo_ticks;
volatile uint16_t kilo_tx_period = 3906;
uint16_t kilo_uid, kilo_irhigh[14], kilo_irlow[14];
uint8_t kilo_turn_left, kilo_turn_right, kilo_straight_left, kilo_straight_right;
static int32_t rand_state = 1;
static void no_rx(message_t* message, distance_measurement_t* distance) {}
static message_t* no_tx(void) {
  return 0;
}
static void no_success(void) {}
message_rx_t kilo_message_rx = no_rx;
message_tx_t kilo_message_tx = no_tx;
message_tx_success_t kilo_message_tx_success = no_success;
message_t arkmesh_message;
distance_measurement_t arkmesh_distance;
static void (*arkmesh_setup)(void);
static void (*arkmesh_loop)(void);

#define measured arkmesh_measured /* nobody asks */
#include "robot_pure.h"

static void serve(void);

static uint32_t call(char letter, uint32_t value, void* from) {
  for (;;) {
    VALUE = value;
    FROM = (uint16_t)from;
    CALL = letter;
    if (!NEXT) return VALUE;
    serve();
  }
}
#define CALLER __builtin_return_address(0)

/* Does what comes next, until the program's turn has come again. */
static void serve(void) {
  for (;;) {
    uint16_t result = 0;
    CALL = '?';
    switch (NEXT) {
      case 'S':
        arkmesh_setup();
        break;
      case 'L':
        arkmesh_loop();
        break;
      case 'X':
        kilo_message_rx(&arkmesh_message, &arkmesh_distance);
        break;
      case 'T':
        result = (uint16_t)kilo_message_tx();
        break;
      case 'U':
        kilo_message_tx_success();
        break;
      case 'B':
        result = rand() & 0xFF;
        break;
      default:
        return;
    }
    call('R', result, 0);
  }
}

/* A program that waits without a call of the library. */
ISR(SPM_READY_vect) {
  const uint32_t value = VALUE;
  const uint16_t from = FROM;
  CALL = 'i';
  if (NEXT) serve();
  VALUE = value;
  FROM = from;
}

/* After the start code, before main(): memory is as the program wants it, now values come from the EEPROM. */
__attribute__((naked, used, section(".init8"))) void arkmesh_begins(void) {
  CALL = 'b';
}

void kilo_init() {
  sei();
}
void kilo_start(void (*setup)(void), void (*loop)(void)) {
  arkmesh_setup = setup;
  arkmesh_loop = loop;
  call('s', SPM_READY_vect_num, CALLER);
  for (;;) serve();
}
static void wait(uint32_t us, void* from) {
  call('d', us, from);
  serve();
}
void delay(uint16_t ms) {
  wait(ms * 1000UL, CALLER);
}
void arkmesh_wait_us(uint32_t us) {
  wait(us, CALLER);
}
void set_motors(uint8_t left, uint8_t right) {
  call('m', left | (uint16_t)right << 8, CALLER);
}
void spinup_motors() {
  call('m', 0xFFFF, CALLER);
  wait(15000, CALLER);
}
void set_color(uint8_t color) {
  call('c', color, CALLER);
}
int16_t get_ambientlight() {
  return call('l', 0, CALLER);
}
int16_t get_voltage() {
  return call('o', 0, CALLER);
}
int16_t get_temperature() {
  return call('e', 0, CALLER);
}
uint8_t rand_hard() {
  return call('h', 0, CALLER);
}
void arkmesh_say(uint8_t kind, int32_t value) {
  *(volatile uint8_t*)0xE8 = kind;
  call('y', value, CALLER);
}

/* As in the robot's C library, with its state in sight. */
int rand(void) {
  const int32_t x = rand_state ? rand_state : 123459876;
  rand_state = 16807 * (x % 127773) - 2836 * (x / 127773);
  if (rand_state < 0) rand_state += 0x7FFFFFFF;
  return rand_state & 0x7FFF;
}
void srand(unsigned seed) {
  rand_state = seed;
}

static int put(char letter, FILE* stream) {
  return 0;
}
static FILE arkmesh_line = FDEV_SETUP_STREAM(put, 0, _FDEV_SETUP_WRITE);
void arkmesh_serial_on(void) {
  stdout = &arkmesh_line;
}

#ifdef ARKMESH_SANITIZED
/* The compiler's checks, in a build that only names what goes wrong where: each begins with a file's name, a line and a
   column. */
#define CHECKED(name, letter)                                           \
  void __ubsan_handle_##name(const uint16_t* place, void* a, void* b) { \
    *(volatile uint8_t*)0xE8 = letter;                                  \
    call('u', *(const uint32_t*)(place + 1), 0);                        \
  }
CHECKED(add_overflow, '+')
CHECKED(sub_overflow, '-')
CHECKED(mul_overflow, '*')
CHECKED(negate_overflow, '-')
CHECKED(divrem_overflow, '/')
CHECKED(shift_out_of_bounds, '<')
CHECKED(out_of_bounds, '[')
CHECKED(float_cast_overflow, 'f')
#endif
