/* Style: relies on the robot's types: bytes and 16-bit numbers that wrap, packed structs, small enums, unsigned char, bit fields.
   Green when all are as on the robot. */
#include <kilolib.h>

typedef struct { uint8_t a; uint16_t b; uint32_t c; } record_t;
typedef enum { ONE = 1, TWO } small_t;
struct bits { uint8_t low : 3, high : 5; };

static uint8_t bad = 0;

void setup() {
    uint8_t byte = 255;
    uint16_t word = 65530;
    char c = 200;
    struct bits bits;
    byte++;
    word += 10;
    bits.low = 9;
    bits.high = 31;
    if (byte != 0) bad |= 1;
    if (word != 4) bad |= 2;
    if (sizeof(record_t) != 7) bad |= 4;
    if (sizeof(small_t) != 1) bad |= 8;
    if (c != 200) bad |= 16;
    if (bits.low != 1 || bits.high != 31 || sizeof(struct bits) != 1) bad |= 32;
    if (sizeof(message_t) != 12 || sizeof(distance_measurement_t) != 4) bad |= 64;
}

void loop() {
    set_color(bad ? RGB(3, 0, 0) : RGB(0, 3, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
