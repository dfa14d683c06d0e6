/* Has decided for site 1, of quality 8, and walks about at random. At a site it senses the quality, and changes over if
   it is better than what it remembers of its own. Elsewhere it follows, now and then, most of the robots near it.
   Red: favours site 1; blue: site 2. */
#include <arkmesh_id.h> /* says who it is, and goes on after a pause */
#include <kilolib.h>

static volatile uint8_t at, quality, most;
static uint32_t motion_ends_at, thinks_at;
static uint8_t favours = 1, known = 8, turning, left, right;

/* One of three blocks: robot 10 bits, kind 4 bits: the site that it is at; then its quality in 8 bits, and in 2 bits
   the site that most robots near it favour. 0 is none. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) != kilo_uid) continue;
    at = block[1] >> 2 & 15;
    quality = (block[1] & 3) << 6 | block[2] >> 2;
    most = block[2] & 3;
  }
}

static void setup(void) {
  motion_ends_at = thinks_at = kilo_ticks;
}

/* Each second. It follows others with probability 10 / 256, and thinks their site as good as the one that it leaves. */
static void think(void) {
  if (at && (at == favours || quality > known)) {
    favours = at;
    known = quality;
  } else if (most && rand_hard() < 10) {
    favours = most;
  }
}

static void loop(void) {
  const uint32_t now = kilo_ticks;
  uint8_t starts = 0;
  if (now >= thinks_at) {
    thinks_at = now + 31;
    think();
  }
  set_color(favours == 1 ? RGB(3, 0, 0) : RGB(0, 0, 3));
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
