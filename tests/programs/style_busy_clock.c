/* Style: waits by reading kilo_ticks in an empty loop. Green on for one second, off for one second; magenta if a wait was short. */
#include <kilolib.h>

void wait_ticks(uint32_t n) {
    uint32_t begin = kilo_ticks;
    while (kilo_ticks < begin + n);
    if (kilo_ticks - begin < n) set_color(RGB(3, 0, 3));
}

void setup() {
    uint32_t until = kilo_ticks + 15;
    while (kilo_ticks < until) { }
}

void loop() {
    set_color(RGB(0, 3, 0));
    wait_ticks(31);
    set_color(RGB(0, 0, 0));
    wait_ticks(31);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
