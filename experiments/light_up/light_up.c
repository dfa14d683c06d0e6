/* Walks about at random and shows COLOUR, white by default, while it is told to by its scenario. */
#include <kilolib.h>

#ifndef COLOUR
#define COLOUR RGB(3, 3, 3)
#endif

enum { DARK = 0, LIT = 1 };

static volatile uint8_t told;
static uint32_t called_at, motion_ends_at;
static uint8_t turning, left, right;

/* One of three blocks: robot 10 bits, kind 4 bits, value 10 bits. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) == kilo_uid) told = block[1] >> 2 & 15;
  }
}

static void setup(void) {
  called_at = motion_ends_at = kilo_ticks;
}

/* Says each time what LED and motors are to do: a pause cuts both, and nobody tells the program. */
static void loop(void) {
  const uint32_t now = kilo_ticks;
  uint8_t starts = now - called_at >= 5; /* it was paused, and its motors stand */
  called_at = now;
  if (told == LIT)
    set_color(COLOUR);
  else
    set_color(RGB(0, 0, 0));
  if (now >= motion_ends_at) {
    /* Straight for 2 to 10 s, then a turn of up to 4 s. */
    turning = !turning;
    starts = 1;
    left = right = 0;
    if (!turning) {
      left = kilo_straight_left;
      right = kilo_straight_right;
      motion_ends_at = now + 60 + rand_hard();
    } else {
      if (rand_hard() & 1)
        left = kilo_turn_left;
      else
        right = kilo_turn_right;
      motion_ends_at = now + rand_hard() / 2;
    }
  }
  if (starts) spinup_motors();
  set_motors(left, right);
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
