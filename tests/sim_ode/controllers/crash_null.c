/* Robot 2 writes through a null pointer after two seconds. */
#include <kilolib.h>
#include <stdlib.h>

static uint8_t *nowhere;
void setup() {}
void loop() {
  if (kilo_ticks > 61 && kilo_uid == 2)
    *nowhere = 1;
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
