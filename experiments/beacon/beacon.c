/* Turns towards the sector that it was told; walks about at random until it is told one. The robot of beacon.py. */
#include <arkmesh_id.h> /* says who it is, and goes on after a pause */
#include <kilolib.h>

enum { WALK = 0, SEEK = 1 };

static volatile uint8_t told, sector;
static uint32_t motion_ends_at;
static uint8_t turning, left, right;

/* One of three blocks: robot 10 bits, kind 4 bits, value 10 bits. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) == kilo_uid) {
      told = block[1] >> 2 & 15;
      sector = block[2] & 7; /* of 45 degrees, counted to the left; 0 is ahead */
    }
  }
}

static void setup(void) {
  motion_ends_at = kilo_ticks;
}

static void loop(void) {
  const uint32_t now = kilo_ticks;
  uint8_t starts = 0;
  if (told == SEEK) {
    const uint8_t l = sector >= 4 ? 0 : sector == 0 ? kilo_straight_left : kilo_turn_left;
    const uint8_t r = sector > 0 && sector < 4 ? 0 : sector == 0 ? kilo_straight_right : kilo_turn_right;
    set_color(sector == 0 ? RGB(0, 3, 0) : sector < 4 ? RGB(3, 0, 0) : RGB(0, 0, 3));
    if (l != left || r != right) starts = 1;
    left = l;
    right = r;
    if (starts) spinup_motors();
    set_motors(left, right);
    return;
  }
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
