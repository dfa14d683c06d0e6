/* Never returns from loop, after two seconds. */
#include <kilolib.h>

volatile int turns = 0;

void setup() {}
void loop() {
    if (kilo_ticks > 62)
        while (1) turns++;
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
