/* Shows in its colour what its sensors read: red light above 600, green between 300 and 600, blue below, white -1; a battery or a
   temperature that is not plausible ends the program. */
#include <assert.h>
#include <kilolib.h>

void setup() {}
void loop() {
  const int16_t light = get_ambientlight(), volts = get_voltage(), warmth = get_temperature();
  assert(light == -1 || (volts > 800 && volts < 950 && warmth > 300 && warmth < 330));
  set_color(light == -1 ? RGB(3, 3, 3) : light > 600 ? RGB(3, 0, 0) : light > 300 ? RGB(0, 3, 0) : RGB(0, 0, 3));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
