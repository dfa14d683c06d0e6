/* delay(0) lets no time pass. */
#include <kilolib.h>

void setup() {
  while (1) delay(0);
}
void loop() {}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
