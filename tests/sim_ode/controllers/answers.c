/* Walks ahead and counts half minutes of its clock in colours: white, cyan, white, ... Answers who it is. */
#include <kilolib.h>
#include <arkmesh_id.h>

static void setup(void) {
  spinup_motors();
  set_motors(kilo_straight_left, kilo_straight_right);
}
static void loop(void) {
  set_color(kilo_ticks / 915 % 2 ? RGB(0, 3, 3) : RGB(3, 3, 3));
}

int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
