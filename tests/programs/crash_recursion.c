/* Calls itself without end. */
#include <kilolib.h>

volatile int depth = 0;

int down(int n) {
    volatile char room[64];
    room[0] = n;
    depth = n;
    return down(n + 1) + room[0];
}

void setup() {}
void loop() {
    if (kilo_ticks > 40) set_color(down(0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
