/* Has a type that no robot's compiler takes. */
#include "kilolib.h"

struct {
  unsigned many : 20; /* line 5 */
} bits;

static void setup(void) {
  set_color(sizeof(int) == 4 && sizeof(double) == 8 ? RGB(0, 1, 0) : RGB(1, 0, 0));
}
static void loop(void) {}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
