#include "kilolib.h"
#include <avr/io.h>

static void setup(void) {
  OCR2A = 70; /* line 5 */
}
static void loop(void) {}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
