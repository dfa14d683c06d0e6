/* An assertion fails in robot 1. */
#include <kilolib.h>
#include <assert.h>

void setup() {}
void loop() {
    if (kilo_ticks > 31) assert(kilo_uid != 1);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
