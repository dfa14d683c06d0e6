/* The robots' side of `arkmesh fit robots`: drives straight on, turns left, drives, turns right and rests, over and
   over, with the calibrated duties, and shows which by its LED. Load it, RUN it. Turns last 5 to 10 s by chance, so
   robots do not come back to the same wall. LED: straight green, left red, right blue, rest white. */
#include <arkmesh_id.h>
#include <kilolib.h>
#include <stdint.h>

enum { STRAIGHT_TICKS = 186, TURN_TICKS = 155, REST_TICKS = 46 };

static uint8_t step; /* 0 and 2 straight, 1 left, 3 right, 4 rest */
static uint32_t until;

static void begin(void) {
  uint8_t left = 0, right = 0, colour = RGB(3, 3, 3);
  uint16_t ticks = step < 4 ? STRAIGHT_TICKS : REST_TICKS;
  if (step == 0 || step == 2) {
    left = kilo_straight_left;
    right = kilo_straight_right;
    colour = RGB(0, 3, 0);
  } else if (step < 4) {
    if (step == 1)
      left = kilo_turn_left;
    else
      right = kilo_turn_right;
    colour = step == 1 ? RGB(3, 0, 0) : RGB(0, 0, 3);
    ticks = TURN_TICKS + rand_soft() % TURN_TICKS;
  }
  until = kilo_ticks + ticks;
  set_color(colour);
  if (left || right) spinup_motors();
  set_motors(left, right);
}

static void loop(void) {
  if ((int32_t)(kilo_ticks - until) < 0) return;
  step = (uint8_t)(step < 4 ? step + 1 : 0);
  begin();
}

static void setup(void) {
  rand_seed((uint8_t)kilo_uid);
  begin();
}

int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
