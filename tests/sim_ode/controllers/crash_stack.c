/* Never stops calling itself, after a delay. */
#include <kilolib.h>

volatile int depth;
int deeper(int n) {
  volatile char room[100];
  room[n % 100] = n;
  return deeper(n + 1) + room[0];
}
void setup() { delay(100); }
void loop() { depth = deeper(depth); }
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
