/* Always lit, and lit anew within each tick: when loop runs once too often, the LED stays lit. */
#include "kilolib.h"

static void setup(void) {}
static void loop(void) {
    set_color(RGB(3, 0, 0));
    delay(1);
    set_color(RGB(0, 3, 0));
}
int main(void) {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
