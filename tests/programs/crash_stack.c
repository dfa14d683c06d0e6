/* Calls itself a few times, each with a local array far larger than a robot's memory: the robot's compiler takes it all the same. */
#include <kilolib.h>

int sum(int n) {
    volatile int table[15000];
    int i, s = 0;
    for (i = 0; i < 15000; i++) table[i] = n;
    if (n > 0) s = sum(n - 1);
    for (i = 0; i < 15000; i++) s += table[i];
    return s;
}

void setup() {}
void loop() {
    if (kilo_ticks > 31 && sum(8)) set_color(RGB(1, 0, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
