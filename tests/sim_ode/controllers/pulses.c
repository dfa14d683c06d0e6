/* Runs both motors at MOTOR in the first ON ticks of each PERIOD, and shines then; with RANDOM anew by chance in each tick. */
#include <kilolib.h>

void setup() {}
void loop() {
#ifdef RANDOM
  const uint8_t motor = rand_soft();
#else
  const uint8_t motor = kilo_ticks % PERIOD < ON ? MOTOR : 0;
#endif
  set_motors(motor, motor);
  set_color(motor ? RGB(LIGHT, 0, 0) : 0);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
