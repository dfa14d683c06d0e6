/* Walks about at random and shows white while it is told to. The robot of the light-up scenario. */
#include <kilolib.h>

enum { DARK = 0, LIT = 1 };

static volatile uint8_t told;
static uint32_t motion_ends_at;
static uint8_t turning;

/* One of three blocks: robot 10 bits, kind 4 bits, value 10 bits. */
static void on_message(message_t *message, distance_measurement_t *distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t *block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) == kilo_uid) told = block[1] >> 2 & 15;
  }
}

static void setup(void) { motion_ends_at = kilo_ticks; }

static void loop(void) {
  if (told == LIT) set_color(RGB(3, 3, 3));
  else set_color(RGB(0, 0, 0));
  if (kilo_ticks < motion_ends_at) return;
  /* Straight for 2 to 10 s, then a turn of up to 4 s. */
  turning = !turning;
  spinup_motors();
  if (!turning) {
    set_motors(kilo_straight_left, kilo_straight_right);
    motion_ends_at = kilo_ticks + 60 + rand_hard();
  } else {
    if (rand_hard() & 1) set_motors(kilo_turn_left, 0);
    else set_motors(0, kilo_turn_right);
    motion_ends_at = kilo_ticks + rand_hard() / 2;
  }
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
