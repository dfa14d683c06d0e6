/* The naming game: everybody holds a list of words, says one of them now and then, and agrees when it hears one that it knows.
   Colour: the word, when only one is left; off otherwise. */
#include <kilolib.h>
#include <stdlib.h>

#define MAX_WORDS 32
#define WORDS 7   /* words are 1 to 7 and are colours */

uint8_t inventory[MAX_WORDS];
uint8_t size = 0;
uint32_t last_said = 0;
uint8_t saying = 0;
uint8_t heard_word = 0, heard_new = 0;
message_t msg;

uint8_t knows(uint8_t word) {
    uint8_t i;
    for (i = 0; i < size; i++)
        if (inventory[i] == word) return 1;
    return 0;
}

void setup() {
    srand(rand_hard() << 7 | kilo_uid);
    last_said = kilo_ticks + rand() % 64;
}

void loop() {
    if (heard_new) {
        heard_new = 0;
        if (knows(heard_word)) {
            inventory[0] = heard_word;
            size = 1;
        } else if (size < MAX_WORDS) {
            inventory[size++] = heard_word;
        }
    }
    if (!saying && kilo_ticks > last_said + 32) {
        last_said = kilo_ticks + rand() % 32;
        if (size == 0) inventory[size++] = 1 + rand() % WORDS;
        msg.type = NORMAL;
        msg.data[0] = inventory[rand() % size];
        msg.crc = message_crc(&msg);
        saying = 1;
    }
    if (size == 1) set_color(RGB(inventory[0] & 1 ? 3 : 0, inventory[0] & 2 ? 3 : 0, inventory[0] & 4 ? 3 : 0));
    else set_color(RGB(0, 0, 0));
}

message_t *tx() { return saying ? &msg : NULL; }
void tx_success() { saying = 0; }
void rx(message_t *m, distance_measurement_t *d) {
    heard_word = m->data[0];
    heard_new = 1;
}

int main() {
    kilo_init();
    kilo_message_tx = tx;
    kilo_message_tx_success = tx_success;
    kilo_message_rx = rx;
    kilo_start(setup, loop);
    return 0;
}
