/* The random walk of CRE's robots, and what they do about walls. For one file of a program, behind kilolib.h; that file
   calls walk() in its loop. */
#ifndef CRE_WALK_H
#define CRE_WALK_H

#include <kilolib.h>
#include <math.h>
#include <stdint.h>

#include "cre_messages.h"

/* The walk: straights of Levy-stable length with exponent 2 (normal, of standard deviation sqrt(2) times the scale),
   turns of wrapped-Cauchy angle (constants of the published CRE). */
#define LEVY_SCALE_TICKS 320.0f
#define LONGEST_STRAIGHT_TICKS 30000.0f
#define CAUCHY_RHO 0.4f
#define TURN_BY_PI_TICKS 120
/* Walls are forgotten when they are not told again. */
#define WALL_MEMORY_TICKS 61
#define WALL_TURN_TICKS 62

#define HALF_TURN 3.14159265f

enum motion { RESTING, AHEAD, TURNING_LEFT, TURNING_RIGHT };

static uint8_t motion;
static uint8_t free_side; /* where to turn when a wall is straight ahead */
static uint8_t wall;
static uint32_t wall_heard_at;
static uint32_t motion_ends_at;
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

/* kilo_ticks advances by 61 in 2 s. */
static uint16_t ticks_of_tenths(uint8_t tenths) {
  return (uint16_t)((uint16_t)tenths * 61 / 20);
}

/* Xorshift, never 0. */
static uint32_t random_word(void) {
  random_state ^= random_state << 13;
  random_state ^= random_state >> 17;
  random_state ^= random_state << 5;
  return random_state;
}

/* Uniform in (0, 1), ends excluded. */
static float random_unit(void) {
  return ((float)(random_word() >> 9) + 0.5f) / 8388608.0f;
}

static void set_up_random(void) {
  uint8_t i;
  for (i = 0; i < 4; ++i) random_state = random_state << 8 | rand_hard();
  if (random_state == 0) random_state = 1;
  free_side = rand_hard() & 1 ? TURNING_LEFT : TURNING_RIGHT;
}

/* |X| of a normal X (Box and Muller). */
static uint16_t straight_ticks(void) {
  const float x = sqrtf(-4.0f * logf(random_unit())) * sinf((random_unit() - 0.5f) * 2.0f * HALF_TURN);
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

static void hear_wall(uint32_t now, uint8_t heard) {
  wall = heard;
  wall_heard_at = now;
}

/* Turns away from a wall in front, and some way on; the straight that follows is a new one. False: there is none. */
static uint8_t avoid_wall(uint32_t now) {
  if (now - wall_heard_at > WALL_MEMORY_TICKS) wall = CRE_NO_WALL;
  if (wall == CRE_NO_WALL) return 0;
  if (wall == CRE_WALL_LEFT) free_side = TURNING_RIGHT;
  if (wall == CRE_WALL_RIGHT) free_side = TURNING_LEFT;
  if (motion != free_side || is_over(motion_ends_at, now)) motion_ends_at = now + WALL_TURN_TICKS;
  move(free_side);
  return 1;
}

/* One step of the random walk where no wall is. */
static void walk(uint32_t now) {
  if (!is_over(motion_ends_at, now)) return;
  if (motion == AHEAD) {
    move(random_unit() < 0.5f ? TURNING_LEFT : TURNING_RIGHT);
    motion_ends_at = now + turn_ticks();
  } else {
    go_ahead(now);
  }
}

#endif
