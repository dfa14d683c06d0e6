/* Favours one of two sites, at first whichever. It walks about at random and learns of a site each second: of the one
   that it is at, else from a robot near it. A good site wins it over more often than a poor one. It decides for good
   when enough others near it favour the same. Red: favours site 1; blue: site 2; yellow and cyan: has decided so. */
#include <arkmesh_id.h> /* says who it is, and goes on after a pause */
#include <kilolib.h>

static volatile uint8_t site, quality, near[3], quorum = 255;
static uint32_t motion_ends_at, thinks_at;
static uint8_t favours = 1, decided, turning, left, right;

/* Type 1 holds the quorum. Type 0 has three blocks: robot 10 bits, kind 4 bits: the site that it learns of; then its
   quality in 4 bits, and in 3 bits each how many near robots favour site 1 and site 2. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type == 1) quorum = message->data[0];
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) != kilo_uid) continue;
    site = block[1] >> 2 & 15;
    quality = (block[1] & 3) << 2 | block[2] >> 6;
    near[1] = block[2] >> 3 & 7;
    near[2] = block[2] & 7;
  }
}

static void setup(void) {
  motion_ends_at = thinks_at = kilo_ticks;
  favours = 1 + (rand_hard() & 1);
}

/* Each second: a site wins it over with probability quality / 64. */
static void think(void) {
  if (decided) return;
  if (site && rand_hard() < 4 * quality) favours = site;
  decided = near[favours] >= quorum;
}

static void show(void) {
  const uint8_t green = decided ? 3 : 0;
  set_color(favours == 1 ? RGB(3, green, 0) : RGB(0, green, 3));
}

static void loop(void) {
  const uint32_t now = kilo_ticks;
  uint8_t starts = 0;
  if (now >= thinks_at) {
    thinks_at = now + 31;
    think();
  }
  show();
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
