/* Style: the same calls of printf without DEBUG: they vanish, arguments and all. */
#include <kilolib.h>
#include "debug.h"

uint8_t calls = 0;
int called() { calls++; return 1; }

void setup() { debug_init(); }
void loop() {
    printf("%d\n", called());
    set_color(calls == 0 ? RGB(0, 3, 0) : RGB(3, 0, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
