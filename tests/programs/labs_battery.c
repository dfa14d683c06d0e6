/* Exercise in sensors: shows battery (green good, red flat) and temperature (white while neither can be read). */
#include <kilolib.h>

int16_t volts, warmth;

void setup() {}

void loop() {
    volts = get_voltage();
    warmth = get_temperature();
    if (volts == -1 || warmth == -1) {
        set_color(RGB(1, 1, 1));
        return;
    }
    if (volts > 614) set_color(RGB(0, 2, 0));
    else set_color(RGB(2, 0, 0));
    delay(200);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
