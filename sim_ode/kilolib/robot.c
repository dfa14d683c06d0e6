/* The robot's side of the library: linked into each program. All of a robot's state here lies in section .robot_host,
   which is exchanged together with the program's own data when the turn passes from robot to robot. */
#include <stdlib.h>

#include "robot_parts.h"
#include "robot_pure.h"
#include "thymio.h"

static void no_rx(message_t* message, distance_measurement_t* distance) {
  (void)message;
  (void)distance;
}
static message_t* no_tx(void) {
  return 0;
}
static void no_success(void) {}

ROBOT volatile uint32_t arkmesh_ticks = 0;
ROBOT uint32_t arkmesh_reads = 0;
ROBOT uint32_t arkmesh_work = 0;
ROBOT static uint16_t timer_reads = 0;
ROBOT static uint8_t timer_value[2] = {0};
ROBOT message_rx_t kilo_message_rx = no_rx;
ROBOT message_tx_t kilo_message_tx = no_tx;
ROBOT message_tx_success_t kilo_message_tx_success = no_success;
ROBOT static void (*user_setup)(void) = 0;
ROBOT static void (*user_loop)(void) = 0;
ROBOT uint16_t kilo_uid = 0;
ROBOT volatile uint16_t kilo_tx_period = 3906;
ROBOT uint8_t kilo_turn_left = 0;
ROBOT uint8_t kilo_turn_right = 0;
ROBOT uint8_t kilo_straight_left = 0;
ROBOT uint8_t kilo_straight_right = 0;
ROBOT static message_t rx_message = {{0}};
ROBOT static distance_measurement_t rx_distance = {0};
ROBOT uint16_t kilo_irhigh[14] = {0};
ROBOT uint16_t kilo_irlow[14] = {0};

/* Outside the robot's memory. Until the simulator fills it in, for constructors, nothing happens. */
static int nothing(void) {
  return 0;
}
#define NOTHING (void*)nothing
#define FOUR NOTHING, NOTHING, NOTHING, NOTHING
#define FUNCTION(name) NOTHING,
__attribute__((section(".arkmesh_host"))) struct arkmesh_host arkmesh_calls = {
    FOUR, FOUR, FOUR, FOUR, FOUR, NOTHING, NOTHING, ARKMESH_MATHEMATICS(FUNCTION, FUNCTION)};
#undef FOUR
#undef NOTHING
#undef FUNCTION

/* ---- time ---- */

void arkmesh_give_time(const void* from) {
  arkmesh_work = 0;
  arkmesh_calls.busy_at(from,
                        kilo_message_rx != no_rx || kilo_message_tx != no_tx || kilo_message_tx_success != no_success);
}
void arkmesh_wait_us(uint32_t us) {
  arkmesh_calls.wait_us(us, CALLER);
}
void delay(uint16_t ms) {
  arkmesh_calls.wait_us((uint32_t)ms * 1000, CALLER);
}
void arkmesh_busy(void) {
  arkmesh_reads = 0;
  arkmesh_calls.wait_for_tick(CALLER);
}

/* A sensor takes about as long as it takes the clock to be read often. */
#define SPEND_READING()                    \
  do {                                     \
    if (++arkmesh_reads >= 400) {          \
      arkmesh_reads = 0;                   \
      arkmesh_calls.wait_for_tick(CALLER); \
    }                                      \
  } while (0)

/* Programs with volatile variables are compiled so that each access to memory calls one of these: waiting for a flag
   that a callback sets takes time then, as on the robot. Only reads of volatile variables count, so that a loop without
   any still is an endless one. */
#define LOOKED_AT(name)                 \
  HIDDEN void name(void* place) {       \
    if (place == (void*)&arkmesh_ticks) \
      SPEND_READING();                  \
    else                                \
      SPEND(12);                        \
  }
#define UNCOUNTED(name)           \
  HIDDEN void name(void* place) { \
    (void)place;                  \
  }
#define OF_ALL_SIZES(what, name) what(name##1) what(name##2) what(name##4) what(name##8) what(name##16)
OF_ALL_SIZES(LOOKED_AT, __tsan_volatile_read)
OF_ALL_SIZES(LOOKED_AT, __tsan_unaligned_volatile_read)
OF_ALL_SIZES(UNCOUNTED, __tsan_volatile_write)
OF_ALL_SIZES(UNCOUNTED, __tsan_unaligned_volatile_write)
OF_ALL_SIZES(UNCOUNTED, __tsan_read)
OF_ALL_SIZES(UNCOUNTED, __tsan_write)
OF_ALL_SIZES(UNCOUNTED, __tsan_unaligned_read)
OF_ALL_SIZES(UNCOUNTED, __tsan_unaligned_write)
HIDDEN void __tsan_read_range(void* place, unsigned long size) {
  (void)place;
  (void)size;
}
HIDDEN void __tsan_write_range(void* place, unsigned long size) {
  (void)place;
  (void)size;
}
HIDDEN void __tsan_init(void) {}

/* Timers 0 to 2, which count on at 128 microseconds; what is written is lost. */
HIDDEN uint8_t* arkmesh_timer(void) {
  SPEND(1);
  timer_value[0] = (uint8_t)(arkmesh_ticks * 255 + ++timer_reads * 3u);
  timer_value[1] = (uint8_t)timer_reads;
  return timer_value;
}

/* ---- body ---- */

extern uint8_t arkmesh_registers[] HIDDEN __attribute__((weak)); /* of avr/io.h */

void set_motors(uint8_t left, uint8_t right) {
  SPEND(8);
  if (arkmesh_registers) arkmesh_registers[18] = left, arkmesh_registers[19] = right;
  arkmesh_calls.motors(left, right);
}
void set_color(uint8_t color) {
  SPEND(8);
  if (arkmesh_registers) { /* DDRC and DDRD: red 5, 4 of D, green 3, 2 and blue 5, 4 of C */
    arkmesh_registers[4] =
        (arkmesh_registers[4] & 0xC3) | (color & 4) << 1 | (color & 8) >> 1 | (color & 16) << 1 | (color & 32) >> 1;
    arkmesh_registers[7] = (arkmesh_registers[7] & 0xCF) | (color & 1) << 5 | (color & 2) << 3;
  }
  arkmesh_calls.colour(color);
}
void spinup_motors() {
  set_motors(255, 255);
  delay(15);
}

int16_t get_ambientlight() {
  SPEND_READING();
  return arkmesh_calls.light();
}
int16_t get_voltage() {
  SPEND_READING();
  return arkmesh_calls.voltage();
}
int16_t get_temperature() {
  SPEND_READING();
  return arkmesh_calls.temperature();
}

/* ---- chance ---- */

uint8_t rand_hard() {
  SPEND(100);
  return arkmesh_calls.random_byte();
}

/* ---- messages ---- */

/* The channel was busy: another timer interrupt comes after so many of the timer's counts, and counts as a tick. */
static uint8_t back_off(void) {
  arkmesh_ticks++;
  return rand() & 0xFF;
}

int16_t thymio_prox(uint8_t sensor) {
  SPEND_READING();
  return arkmesh_calls.prox(sensor, CALLER);
}
HIDDEN void arkmesh_say(uint8_t kind, int32_t value) {
  SPEND(8);
  arkmesh_calls.say(kind, value, CALLER);
}

/* ---- start and end ---- */

void kilo_init() {}
void kilo_start(void (*setup)(void), void (*loop)(void)) {
  user_setup = setup;
  user_loop = loop;
  arkmesh_calls.started();
}

HIDDEN void arkmesh_gives_up(const char* why) {
  arkmesh_calls.ended(why, CALLER);
}

/* ---- what the simulator sees ---- */

extern char arkmesh_begin[] HIDDEN, arkmesh_end[] HIDDEN, arkmesh_own[] HIDDEN;
extern char arkmesh_eeprom_begin[] HIDDEN, arkmesh_eeprom_end[] HIDDEN;
extern uint8_t arkmesh_eeprom[] HIDDEN __attribute__((weak)); /* of avr/eeprom.h */
extern int main();

/* A robot's main() has no arguments, whatever it is written with. */
static int run_main(void) {
  return ((int (*)(int, char**))main)(0, 0);
}

__attribute__((visibility("default"))) const struct arkmesh_program arkmesh_program = {
    .begin = arkmesh_begin,
    .end = arkmesh_end,
    .own = arkmesh_own,
    .eeprom_begin = arkmesh_eeprom_begin,
    .eeprom_end = arkmesh_eeprom_end,
    .eeprom = arkmesh_eeprom,
    .host = &arkmesh_calls,
    .main = run_main,
    .setup = &user_setup,
    .loop = &user_loop,
    .rx = (void (**)(void*, void*)) & kilo_message_rx,
    .tx = (void* (**)(void)) & kilo_message_tx,
    .no_tx = (void* (*)(void))no_tx,
    .tx_success = &kilo_message_tx_success,
    .rx_message = &rx_message,
    .rx_distance = (int16_t*)&rx_distance,
    .measured = &measured,
    .ticks = &arkmesh_ticks,
    .reads = &arkmesh_reads,
    .blocks = &arkmesh_work,
    .uid = &kilo_uid,
    .tx_period = &kilo_tx_period,
    .turn_left = &kilo_turn_left,
    .turn_right = &kilo_turn_right,
    .straight_left = &kilo_straight_left,
    .straight_right = &kilo_straight_right,
    .irhigh = kilo_irhigh,
    .irlow = kilo_irlow,
    .back_off = back_off,
    .registers = arkmesh_registers,
#ifdef ARKMESH_PC_TYPES
    .pc_types = ARKMESH_PC_TYPES,
#endif
};
