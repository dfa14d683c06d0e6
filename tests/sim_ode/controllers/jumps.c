/* Within loop it may jump, out of a callback it may not. */
#include "kilolib.h"
#include <setjmp.h>

static jmp_buf place;

static void rx(message_t* message, distance_measurement_t* distance) {
    longjmp(place, 1); /* line 8 */
}
static void setup(void) {}
static void loop(void) {
    if (setjmp(place)) return;
    if (kilo_ticks % 2) longjmp(place, 1);
    delay(500);
}
int main(void) {
    kilo_init();
    kilo_message_rx = rx;
    kilo_start(setup, loop);
    return 0;
}
