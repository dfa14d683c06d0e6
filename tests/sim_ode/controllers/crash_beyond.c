/* Writes far beyond its own memory. */
#include <kilolib.h>

int small[4];
volatile int n = 30000;
void setup() {}
void loop() {
  int i;
  for (i = 0; i < n; i++) small[i] = i;
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
