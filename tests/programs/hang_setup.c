/* Never returns from setup. */
#include <kilolib.h>

void setup() {
    for (;;) ;
}
void loop() { set_color(RGB(0, 3, 0)); }

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
