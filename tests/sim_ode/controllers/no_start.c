/* main() returns without starting anything. */
#include <kilolib.h>

int main() {
  kilo_init();
  return 0;
}
