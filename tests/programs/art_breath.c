/* An art piece: breathes through the brightness levels with long pauses; the whole of it is delay(). */
#include <kilolib.h>

void breath(uint8_t r, uint8_t g, uint8_t b) {
    uint8_t level;
    for (level = 1; level <= 3; level++) {
        set_color(RGB(level * r, level * g, level * b));
        delay(400);
    }
    for (level = 3; level > 0; level--) {
        set_color(RGB((level - 1) * r, (level - 1) * g, (level - 1) * b));
        delay(400);
    }
}

void setup() {
    delay(kilo_uid * 200);
}

void loop() {
    breath(1, 0, 0);
    delay(3000);
    breath(0, 0, 1);
    delay(5000);
    breath(1, 0, 1);
    delay(8000);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
