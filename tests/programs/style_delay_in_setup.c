/* Style: a long setup with delays and sensor readings, then a loop that never waits. Yellow in setup, green afterwards. */
#include <kilolib.h>

int16_t samples[20];

void setup() {
    uint8_t i;
    set_color(RGB(3, 3, 0));
    for (i = 0; i < 20; i++) {
        samples[i] = get_ambientlight();
        delay(100);
    }
}

void loop() { set_color(RGB(0, 3, 0)); }

int main() {
    kilo_init();
    delay(50);
    kilo_start(setup, loop);
    return 0;
}
