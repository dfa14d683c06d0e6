/* A robot has nowhere to exit to. */
#include <stdlib.h>
#include <kilolib.h>

void setup() {}
void loop() { exit(3); }
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
