/* Style: sets kilo_ticks to zero at each change of state and compares with small numbers from then on. Red 1 s, green 2 s, blue 1 s. */
#include <kilolib.h>

int state = 0;

void setup() { kilo_ticks = 0; }

void loop() {
    switch (state) {
    case 0:
        set_color(RGB(3, 0, 0));
        if (kilo_ticks > 31) { state = 1; kilo_ticks = 0; }
        break;
    case 1:
        set_color(RGB(0, 3, 0));
        if (kilo_ticks > 62) { state++; kilo_ticks = 0; }
        break;
    case 2:
        set_color(RGB(0, 0, 3));
        if (kilo_ticks > 31) { state = 0; kilo_ticks -= kilo_ticks; }
        break;
    }
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
