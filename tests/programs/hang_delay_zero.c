/* Waits for ever with delay(0), in which no time passes. */
#include <kilolib.h>

volatile uint8_t flag = 0;

void setup() {}
void loop() {
    while (!flag) delay(0);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
