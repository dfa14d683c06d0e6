/* Style: everything in statics inside functions, arrays and strings included. Green while no other robot has touched them. */
#include <kilolib.h>
#include <string.h>

uint16_t next(void) {
    static uint16_t n = 100;
    return ++n;
}

char *name(void) {
    static char text[8] = "robot";
    static uint8_t filled;
    if (!filled) {
        text[5] = 'A' + kilo_uid % 26;
        filled = 1;
    }
    return text;
}

void setup() { next(); }

void loop() {
    static uint16_t last = 101;
    static const char *first_name = 0;
    uint16_t n = next();
    uint8_t good = n == (uint16_t)(last + 1) && name()[5] == 'A' + kilo_uid % 26 && strlen(name()) == 6;
    if (!first_name) first_name = name();
    good = good && first_name == name();
    last = n;
    set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0));
    if (!good) while (1) delay(1000);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
