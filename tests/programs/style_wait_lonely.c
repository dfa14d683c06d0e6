/* Style: waits in setup for a start message that never comes, in an empty loop: that is no fault, the robot just waits. Blue. */
#include <kilolib.h>
volatile int started = 0;
void rx(message_t *m, distance_measurement_t *d) { if (m->type == 99) started = 1; }
void setup() {
    set_color(RGB(0, 0, 3));
    while (!started);
    set_color(RGB(3, 0, 0));
}
void loop() {}
int main() { kilo_init(); kilo_message_rx = rx; kilo_start(setup, loop); return 0; }
