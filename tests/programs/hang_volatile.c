/* Uses a volatile flag, but loops for ever without looking at it. */
#include <kilolib.h>
volatile int flag = 0;
void rx(message_t *m, distance_measurement_t *d) { flag = 1; }
void setup() {}
void loop() {
    if (kilo_ticks > 100) {
        for (;;) { }
    }
}
int main() { kilo_init(); kilo_message_rx = rx; kilo_start(setup, loop); return 0; }
