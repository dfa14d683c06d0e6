#include "kilolib.h"

int main(void) {
  kilo_init();
  for (;;) {
    set_color(RGB(1, 0, 0));
    delay(500);
  }
}
