/* Goes where it is told: home, by the sector of its bearing, or along pheromone that it smells in front, else about at
   random. Blue on its way home, which is when it lays pheromone; green else. */
#include <arkmesh_id.h> /* says who it is, and goes on after a pause */
#include <kilolib.h>

enum { SEARCH = 0, HOME = 1 };

static volatile uint8_t kind, value;
static uint32_t motion_ends_at;
static uint8_t turning, left, right;

/* One of three blocks: robot 10 bits, kind 4 bits, value 10 bits. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) != kilo_uid) continue;
    kind = block[1] >> 2 & 15;
    value = block[2];
  }
}

static void setup(void) {
  motion_ends_at = kilo_ticks;
}

static void drive(uint8_t to_left, uint8_t to_right) {
  const uint8_t starts = (to_left && !left) || (to_right && !right);
  left = to_left;
  right = to_right;
  if (starts) spinup_motors();
  set_motors(left, right);
}

/* Straight for 2 to 10 s, then a turn of up to 2 s. */
static void wander(uint32_t now) {
  uint8_t l = left, r = right;
  if (now >= motion_ends_at) {
    turning = !turning;
    l = turning && !(rand_hard() & 1) ? 0 : kilo_straight_left;
    r = turning && l ? 0 : kilo_straight_right;
    motion_ends_at = now + (turning ? rand_hard() / 4 : 60 + rand_hard());
  }
  drive(l, r);
}

static void loop(void) {
  if (kind == HOME) {
    /* Sectors of 30 degrees, counter-clockwise from straight ahead. */
    set_color(RGB(0, 0, 3));
    if (value == 0)
      drive(kilo_straight_left, kilo_straight_right);
    else if (value <= 6)
      drive(kilo_turn_left, 0);
    else
      drive(0, kilo_turn_right);
    return;
  }
  set_color(RGB(0, 3, 0));
  /* Four zones in front, the leftmost in bit 3. */
  if ((value & 6) || (value & 9) == 9)
    drive(kilo_straight_left, kilo_straight_right);
  else if (value & 8)
    drive(kilo_turn_left, 0);
  else if (value & 1)
    drive(0, kilo_turn_right);
  else
    wander(kilo_ticks);
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
