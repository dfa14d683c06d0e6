/* Sets its callback in setup, waits in delay(), and shows what it hears: magenta after a message of type 7. Answers who it is. */
#include <kilolib.h>
#include "arkmesh_id.h"

static volatile uint8_t heard;

static void on_message(message_t *message, distance_measurement_t *distance) {
  (void)distance;
  if (message->type == 7) heard = 1;
  else heard = 2; /* nothing else is for it */
}
static void setup(void) { kilo_message_rx = on_message; }
static void loop(void) {
  set_color(heard == 2 ? RGB(3, 3, 0) : heard ? RGB(3, 0, 3) : RGB(3, 3, 3));
  set_motors(0, kilo_turn_right);
  delay(700);
}

int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
