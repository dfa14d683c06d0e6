/* Style: a .c that includes a .c and headers of a folder beside it. Green once the parts have worked together. */
#include "parts/shared.h"
#include "parts/steps.c"
#include "kilolib.h"
#include <kilolib.h>

void setup() { step_count = 0; }

void loop() {
    step();
    show(step_count > 10 ? RGB(0, 3, 0) : RGB(3, 0, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
