/* Style: waits in loop for a sensor that changes only with time or never, with a clock to give up by; and for a reading that is
   not -1. Green once the wait has ended. */
#include <kilolib.h>

int16_t light() {
    int16_t l;
    do {
        l = get_ambientlight();
    } while (l == -1);
    return l;
}

void setup() {}

void loop() {
    uint32_t begin = kilo_ticks;
    set_color(RGB(3, 0, 0));
    while (get_voltage() < 2000 && kilo_ticks < begin + 62) {
        if (light() < 0) set_color(RGB(3, 0, 3));
    }
    set_color(RGB(0, 3, 0));
    delay(2000);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
