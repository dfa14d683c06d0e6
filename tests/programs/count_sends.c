/* Counts its own sends and shows the count's lowest three bits as colour; also whether success follows each send. */
#include <kilolib.h>

message_t m;
uint16_t sends = 0;

message_t *tx() { return &m; }
void success() { sends++; }

void setup() {
    m.type = NORMAL;
    m.crc = message_crc(&m);
}
void loop() { set_color(RGB(sends & 1 ? 3 : 0, sends & 2 ? 3 : 0, sends & 4 ? 3 : 0)); }

int main() {
    kilo_init();
    kilo_message_tx = tx;
    kilo_message_tx_success = success;
    kilo_start(setup, loop);
    return 0;
}
