/* Does not compile: a semicolon is missing in line 7. */
#include <kilolib.h>

void setup() {}
void loop() {
    int x
    set_color(x);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
