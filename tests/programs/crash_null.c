/* Writes to a null pointer after two seconds, in robot 3 only. */
#include <kilolib.h>

static int *nowhere = 0;

void setup() {}
void loop() {
    set_color(RGB(0, 1, 0));
    if (kilo_uid == 3 && kilo_ticks > 62) {
        *nowhere = 1;
    }
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
