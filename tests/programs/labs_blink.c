/* First exercise: blinks red, half a second on, half a second off. */
#include <kilolib.h>

void setup() {
}

void loop() {
    set_color(RGB(1, 0, 0));
    delay(500);
    set_color(RGB(0, 0, 0));
    delay(500);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
