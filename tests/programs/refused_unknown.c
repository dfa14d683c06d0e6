/* Does not link: calls a function that nobody has. */
#include <kilolib.h>

void dance_wildly();

void setup() {}
void loop() { dance_wildly(); }

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
