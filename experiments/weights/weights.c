/* Walks about at random and guesses whether most of the floor is bright, by what it senses below it and by what robots
   near it think. How much those count is told at the start. Red: dark; blue: bright. */
#include <arkmesh_id.h> /* says who it is, and goes on after a pause */
#include <kilolib.h>

enum { READING = 1, NEAR = 2, TOLD = 4 };

static volatile uint8_t kind, others, weight; /* weight: of others, of 64 */
static uint32_t motion_ends_at, thinks_at;
static int16_t guess = 128 << 5; /* 0 to 255, in 32nds */
static uint8_t turning, left, right;

/* Type 1 holds the weight. Type 0 has three blocks: robot 10 bits; kind 4 bits: whether it stands on a bright tile, and
   whether anybody is near; and in 10 bits the share of those who think that it is bright, of 255. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type == 1) weight = message->data[0];
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) != kilo_uid) continue;
    kind = block[1] >> 2 & 15;
    others = block[2];
  }
}

static void setup(void) {
  motion_ends_at = thinks_at = kilo_ticks;
}

/* Each second the guess moves by a 16th towards what it senses and hears, or what it senses where nobody is near. */
static void think(void) {
  const int16_t own = kind & READING ? 255 : 0;
  const uint8_t w = kind & NEAR ? weight : 0;
  if (kind & TOLD) guess += 2 * ((w * others + (64 - w) * own) / 64) - guess / 16;
}

static void loop(void) {
  const uint32_t now = kilo_ticks;
  uint8_t starts = 0;
  if (now >= thinks_at) {
    thinks_at = now + 31;
    think();
  }
  set_color(guess < 128 << 5 ? RGB(3, 0, 0) : RGB(0, 0, 3));
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
