/* Waits for a flag that nothing sets. */
#include <kilolib.h>

volatile uint8_t flag;
void setup() {}
void loop() {
  while (!flag) {
  }
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
