/* An ARK program: overhead messages of three blocks (10 bits of robot, 4 of kind, 10 of value). Kind is the LED, value is how many
   ticks it stays on. */
#include <kilolib.h>

typedef enum { false = 0, true = 1 } bool;

bool new_sa_msg = false;
uint8_t sa_type = 0;
uint16_t sa_payload = 0;
uint32_t dark_at = 0;

void parse_smart_arena_message(uint8_t data[9], uint8_t kb_index) {
    uint8_t shift = kb_index * 3;
    sa_type = data[1 + shift] >> 2 & 0x0F;
    sa_payload = ((data[1 + shift] & 0b11) << 8) | data[2 + shift];
    new_sa_msg = true;
}

void rx_message(message_t *msg, distance_measurement_t *d) {
    if (msg->type == 0) {
        int id1 = msg->data[0] << 2 | msg->data[1] >> 6;
        int id2 = msg->data[3] << 2 | msg->data[4] >> 6;
        int id3 = msg->data[6] << 2 | msg->data[7] >> 6;
        if (id1 == kilo_uid) parse_smart_arena_message(msg->data, 0);
        else if (id2 == kilo_uid) parse_smart_arena_message(msg->data, 1);
        else if (id3 == kilo_uid) parse_smart_arena_message(msg->data, 2);
    }
}

void setup() {
    set_color(RGB(0, 0, 0));
}

void loop() {
    if (new_sa_msg == true) {
        new_sa_msg = false;
        dark_at = kilo_ticks + sa_payload;
        set_color(RGB(sa_type & 1 ? 3 : 0, sa_type & 2 ? 3 : 0, sa_type & 4 ? 3 : 0));
    }
    if (kilo_ticks >= dark_at) set_color(RGB(0, 0, 0));
}

int main() {
    kilo_init();
    kilo_message_rx = rx_message;
    kilo_start(setup, loop);
    return 0;
}
