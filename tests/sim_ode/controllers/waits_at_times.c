/* Every other loop waits past the tick. */
#include "kilolib.h"

static int loops = 0;

static void setup(void) {}
static void loop(void) {
    if (loops++ % 2) delay(40);
}
int main(void) {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
