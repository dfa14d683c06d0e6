/* Leaves with exit(), which a robot cannot. */
#include <kilolib.h>
#include <stdlib.h>

void setup() {}
void loop() {
    if (kilo_ticks > 31) exit(0);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
