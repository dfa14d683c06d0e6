/* Walks at random with its LED always on, in a colour that changes now and then; says who it is when it is asked. */
#include <kilolib.h>

#include "arkmesh_id.h"

static uint32_t next;

static void draw(void) {
  static const uint8_t colours[] = {RGB(3, 0, 0), RGB(0, 3, 0), RGB(0, 0, 3), RGB(3, 3, 0),
                                    RGB(3, 0, 3), RGB(0, 3, 3), RGB(3, 3, 3)};
  const uint8_t what = rand_soft() % 4;
  if (rand_soft() % 8 == 0) set_color(colours[rand_soft() % 7]);
  spinup_motors();
  if (what < 2) set_motors(kilo_straight_left, kilo_straight_right);
  if (what == 2) set_motors(kilo_turn_left, 0);
  if (what == 3) set_motors(0, kilo_turn_right);
}
static void setup(void) {
  rand_seed(rand_hard());
  set_color(RGB(0, 3, 0));
}
static void loop(void) {
  if (kilo_ticks < next) return;
  next = kilo_ticks + 30 + rand_soft() % 60;
  draw();
}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
