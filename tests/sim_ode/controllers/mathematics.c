/* Moves as the last bits of what mathematics give: another bit, another way. */
#include <kilolib.h>
#include <math.h>
#include <string.h>
static uint32_t hash = 1;
static void mix(double value) {
  uint64_t bits;
  memcpy(&bits, &value, 8);
  hash = (hash ^ (uint32_t)bits) * 16777619u;
}
void setup() {
  int i;
  for (i = 1; i < 400; i++) {
    const double x = 0.1 + 1.2345 * i + kilo_uid;
    mix(sin(x)), mix(cos(x)), mix(exp(x / 100)), mix(pow(x, 1.7)), mix(atan2(x - 200, 3.3)), mix(log(x)),
        mix(sinf((float)x));
  }
}
void loop() {
  set_motors(hash >> 24 & 127, hash >> 16 & 127);
  set_color(RGB(hash & 3, 0, 0));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
