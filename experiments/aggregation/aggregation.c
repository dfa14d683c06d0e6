/* Walks about at random; is told how many robots are near, stays more likely the more there are, and leaves less
   likely. Red while it stays. */
#include <arkmesh_id.h> /* says who it is, and goes on after a pause */
#include <kilolib.h>

static volatile uint8_t near;
static uint32_t motion_ends_at, decides_at;
static uint8_t stays, turning, left, right;

/* One of three blocks: robot 10 bits, kind 4 bits, value 10 bits. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) == kilo_uid) near = block[2];
  }
}

static void setup(void) {
  motion_ends_at = decides_at = kilo_ticks;
}

/* Each second: stays with probability near / (near + 4), leaves with 1 / (2 (near + 1)^2). */
static void decide(void) {
  const uint16_t chance = rand_hard();
  if (stays)
    stays = chance >= 128 / ((near + 1) * (near + 1));
  else
    stays = chance < (uint16_t)near * 256 / (near + 4);
}

static void loop(void) {
  const uint32_t now = kilo_ticks;
  uint8_t starts = 0;
  if (now >= decides_at) {
    const uint8_t stood = stays;
    decides_at = now + 31;
    decide();
    starts |= stood && !stays;
  }
  set_color(stays ? RGB(3, 0, 0) : RGB(0, 0, 0));
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
  if (stays) {
    set_motors(0, 0);
    return;
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
