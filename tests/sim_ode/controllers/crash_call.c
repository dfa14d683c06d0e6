/* Calls a function through a null pointer. */
#include <kilolib.h>

void (*action)(void);
uint8_t n;

void setup() {}
void loop() {
  action();
  n++;
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
