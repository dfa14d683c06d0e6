/* The DHTF robot, a plain kilolib program: the same file runs in the simulator and on a Kilobot.
   Walks at random in search of tasks (LED blue); dwells at a site whose task wants a team (green), at most for the time
   it was told; leaves when that time is over (red). It senses the virtual world through overhead messages only. */
#include <arkmesh_id.h>
#include <kilolib.h>
#include <math.h>
#include <stdint.h>

#include "dhtf_messages.h"

/* kilo_ticks advances by 61 in 2 s. */
#define TICKS(seconds) ((uint32_t)(seconds)*61 / 2)

/* The walk: straights of Levy-stable length, turns of wrapped-Cauchy angle (constants of the published DHTF). */
#define LEVY_ALPHA 1.4f
#define LEVY_SCALE_TICKS 80.0f
#define LONGEST_STRAIGHT_TICKS 30000.0f
#define CAUCHY_RHO 0.9f
#define TURN_BY_PI_TICKS 120.0f
#define WALL_TURN_TICKS 47
/* Walls are forgotten when they are not told again. */
#define WALL_MEMORY_TICKS TICKS(2)
#define MOST_FREE_SECTORS 2

#define HALF_TURN 3.14159265f

enum state { WALKING, DWELLING, LEAVING };
enum motion { RESTING, AHEAD, TURNING_LEFT, TURNING_RIGHT };

/* Written by on_message only. */
static volatile uint8_t heard_kind;
static volatile uint16_t heard_value;
static volatile uint8_t heard_count;

static uint8_t seen_count;
static uint8_t state;
static uint8_t motion;
static uint8_t free_side;    /* where to turn when a wall is straight ahead */
static uint8_t wall_sectors; /* bit 7 is the leftmost of the front half circle */
static uint32_t wall_heard_at;
static uint32_t motion_ends_at;
static uint32_t dwell_ends_at;
static uint32_t random_state;

/* The timer interrupt may change kilo_ticks between two bytes of a read. */
static uint32_t ticks(void) {
  uint32_t t;
  do {
    t = kilo_ticks;
  } while (t != kilo_ticks);
  return t;
}

static uint8_t is_over(uint32_t end, uint32_t now) {
  return (int32_t)(now - end) >= 0;
}

/* Uniform in (0, 1), ends excluded: xorshift, top 23 bits. */
static float random_unit(void) {
  random_state ^= random_state << 13;
  random_state ^= random_state >> 17;
  random_state ^= random_state << 5;
  return ((float)(random_state >> 9) + 0.5f) / 8388608.0f;
}

/* |X| of a symmetric stable X (Chambers, Mallows, Stuck 1976). */
static uint16_t straight_ticks(void) {
  const float u = (random_unit() - 0.5f) * HALF_TURN;
  const float w = -logf(random_unit());
  const float x = sinf(LEVY_ALPHA * u) / powf(cosf(u), 1.0f / LEVY_ALPHA) *
                  powf(cosf((1.0f - LEVY_ALPHA) * u) / w, (1.0f - LEVY_ALPHA) / LEVY_ALPHA);
  const float length = fabsf(x) * LEVY_SCALE_TICKS;
  return length < LONGEST_STRAIGHT_TICKS ? (uint16_t)length : (uint16_t)LONGEST_STRAIGHT_TICKS;
}

/* |angle| of a wrapped Cauchy angle, 0..pi, as a time to turn. */
static uint16_t turn_ticks(void) {
  const float spread = (1.0f - CAUCHY_RHO) / (1.0f + CAUCHY_RHO);
  const float angle = 2.0f * atanf(spread * tanf((random_unit() - 0.5f) * HALF_TURN));
  return (uint16_t)(fabsf(angle) / HALF_TURN * TURN_BY_PI_TICKS);
}

static void move(uint8_t wanted) {
  if (wanted == motion) return;
  motion = wanted;
  if (motion == RESTING) {
    set_motors(0, 0);
    return;
  }
  spinup_motors();
  if (motion == AHEAD) set_motors(kilo_straight_left, kilo_straight_right);
  if (motion == TURNING_LEFT) set_motors(kilo_turn_left, 0);
  if (motion == TURNING_RIGHT) set_motors(0, kilo_turn_right);
}

static void go_ahead(uint32_t now) {
  move(AHEAD);
  motion_ends_at = now + straight_ticks();
}

static uint8_t count_bits(uint8_t bits) {
  uint8_t n = 0;
  for (; bits; bits &= bits - 1) ++n;
  return n;
}

/* One step of the random walk. */
static void walk(uint32_t now) {
  if (now - wall_heard_at > WALL_MEMORY_TICKS) wall_sectors = 0;
  if (count_bits(wall_sectors) > MOST_FREE_SECTORS) {
    /* Turn away from the side with more wall, and some way on; the straight that follows is a new one. */
    const uint8_t left = wall_sectors >> 4, right = wall_sectors & 15;
    if (left > right) free_side = TURNING_RIGHT;
    if (right > left) free_side = TURNING_LEFT;
    if (motion != free_side || is_over(motion_ends_at, now)) motion_ends_at = now + WALL_TURN_TICKS;
    move(free_side);
  } else if (is_over(motion_ends_at, now)) {
    if (motion == AHEAD) {
      move(random_unit() < 0.5f ? TURNING_LEFT : TURNING_RIGHT);
      motion_ends_at = now + turn_ticks();
    } else {
      go_ahead(now);
    }
  }
}

static void begin_walking(void) {
  state = WALKING;
  set_color(RGB(0, 0, 3));
}

static void begin_dwelling(uint32_t now, uint16_t seconds) {
  state = DWELLING;
  set_color(RGB(0, 3, 0));
  move(RESTING);
  dwell_ends_at = now + TICKS(seconds);
}

static void begin_leaving(uint32_t now) {
  state = LEAVING;
  set_color(RGB(3, 0, 0));
  go_ahead(now);
}

static void on_heard(uint32_t now, uint8_t kind, uint16_t value) {
  wall_sectors = kind == DHTF_TASK ? 0 : (uint8_t)value;
  wall_heard_at = now;
  if (state == WALKING && kind == DHTF_TASK) {
    begin_dwelling(now, value);
  } else if (state == DWELLING && kind != DHTF_TASK) {
    /* The task was executed, or somebody pushed the robot out. */
    begin_walking();
    go_ahead(now);
  } else if (state == LEAVING && kind == DHTF_OUTSIDE) {
    begin_walking();
  }
}

static void loop(void) {
  const uint32_t now = ticks();
  if (seen_count != heard_count) {
    uint8_t kind;
    uint16_t value;
    /* Again when a message comes in between. */
    do {
      seen_count = heard_count;
      kind = heard_kind;
      value = heard_value;
    } while (seen_count != heard_count);
    on_heard(now, kind, value);
  }
  if (state == DWELLING) {
    if (is_over(dwell_ends_at, now)) begin_leaving(now);
  } else {
    walk(now);
  }
}

/* An overhead message holds three blocks of 24 bits: robot 10, kind 4, value 10. Runs inside the receive interrupt. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    const uint16_t robot = (uint16_t)block[0] << 2 | block[1] >> 6;
    if (robot != kilo_uid) continue;
    heard_kind = block[1] >> 2 & 15;
    heard_value = (uint16_t)(block[1] & 3) << 8 | block[2];
    ++heard_count;
  }
}

static void setup(void) {
  uint8_t i;
  for (i = 0; i < 4; ++i) random_state = random_state << 8 | rand_hard();
  if (random_state == 0) random_state = 1;
  free_side = rand_hard() & 1 ? TURNING_LEFT : TURNING_RIGHT;
  begin_walking();
  go_ahead(ticks());
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
