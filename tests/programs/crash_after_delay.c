/* Waits with delay() and then reads far outside its memory. */
#include <kilolib.h>

char table[16];
volatile long far_away = 900000000L;

void setup() {}
void loop() {
    set_color(RGB(0, 0, 3));
    delay(3000);
    if (kilo_uid == 2) set_color(table[far_away]);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
