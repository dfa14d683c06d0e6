/* Style: the waiting loop and its volatile flag lie in a file that this one includes. Green after each message. */
#include <kilolib.h>
#include "parts/wait.c"
message_t m;
message_t *message_tx() { return &m; }
void setup() { m.type = NORMAL; m.crc = message_crc(&m); }
void loop() {
    wait_for_message();
    set_color(RGB(0, 3, 0));
}
int main() { kilo_init(); kilo_message_rx = message_rx; kilo_message_tx = message_tx; kilo_start(setup, loop); return 0; }
