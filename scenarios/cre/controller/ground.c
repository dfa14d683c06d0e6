/* The ground robot of CRE, a plain kilolib program: the same file runs in the simulator and on a Kilobot.
   Walks at random (LED off); when the lab lets it hear a flying robot, it turns to that one's region by its compass
   (red north, blue south), goes straight for a while (white), and walks on. It harvests by passing over a resource: the
   lab sees to that. */
#include <arkmesh_id.h>
#include <kilolib.h>
#include <stdint.h>

#include "cre_decisions.h"
#include "cre_messages.h"
#include "cre_walk.h"

enum state { WALKING, TURNING, GOING };

/* Written by on_message only; the counts tell that something came. */
static volatile uint8_t heard_wall, wall_count;
static volatile uint8_t heard_region;
static volatile uint16_t heard_heading;
static volatile uint8_t heard_count;
static volatile uint8_t heard_straight = 30; /* tenths of a second */

static uint8_t seen_wall, seen_count;
static uint8_t state;

static void begin_walking(void) {
  state = WALKING;
  set_color(RGB(0, 0, 0));
}

static void begin_going(uint32_t now) {
  state = GOING;
  set_color(RGB(3, 3, 3));
  move(AHEAD);
  motion_ends_at = now + ticks_of_tenths(heard_straight);
}

static void begin_turning(uint32_t now, uint8_t region, uint16_t heading) {
  const int16_t turn = cre_turn_towards(region, heading);
  const uint16_t angle = (uint16_t)(turn < 0 ? -turn : turn);
  state = TURNING;
  set_color(region == CRE_NORTH ? RGB(3, 0, 0) : RGB(0, 0, 3));
  move(turn < 0 ? TURNING_RIGHT : TURNING_LEFT);
  motion_ends_at = now + (uint16_t)(angle * TURN_BY_PI_TICKS / (CRE_TURN / 2));
}

/* What came since the last call; read again when something comes in between. */
static void take_messages(uint32_t now) {
  if (seen_wall != wall_count) {
    seen_wall = wall_count;
    hear_wall(now, heard_wall);
  }
  if (seen_count != heard_count) {
    uint8_t region;
    uint16_t heading;
    do {
      seen_count = heard_count;
      region = heard_region;
      heading = heard_heading;
    } while (seen_count != heard_count);
    if (state == WALKING && wall == CRE_NO_WALL) begin_turning(now, region, heading);
  }
}

static void loop(void) {
  const uint32_t now = ticks();
  take_messages(now);
  if (avoid_wall(now)) {
    if (state != WALKING) begin_walking();
  } else if (state == WALKING) {
    walk(now);
  } else if (is_over(motion_ends_at, now)) {
    if (state == TURNING) {
      begin_going(now);
    } else {
      /* On in the same direction, as far as the walk's next straight goes. */
      begin_walking();
      go_ahead(now);
    }
  }
}

/* An overhead message holds three blocks of 24 bits: robot 10, kind 4, value 10. Runs inside the receive interrupt. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type == CRE_TYPE_RULES) heard_straight = message->data[CRE_RULE_STRAIGHT];
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    const uint16_t robot = (uint16_t)block[0] << 2 | block[1] >> 6;
    const uint8_t kind = block[1] >> 2 & 15;
    if (robot != kilo_uid) continue;
    if (kind <= CRE_WALL_AHEAD) {
      heard_wall = kind;
      ++wall_count;
    } else if (kind == CRE_HEARD_NORTH || kind == CRE_HEARD_SOUTH) {
      heard_region = kind == CRE_HEARD_NORTH ? CRE_NORTH : CRE_SOUTH;
      heard_heading = (uint16_t)(block[1] & 3) << 8 | block[2];
      ++heard_count;
    }
  }
}

static void setup(void) {
  set_up_random();
  begin_walking();
  go_ahead(ticks());
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
