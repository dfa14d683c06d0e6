/* Style: relies on numbers that wrap: bytes, 16-bit differences of time, a checksum, a generator of its own; all with the types that say
   how wide they are. Green when right. */
#include <kilolib.h>
static uint8_t lfsr = 0xB5;
static uint16_t crc_like(const uint8_t *p, uint8_t n) { uint16_t s = 0; while (n--) s = (uint16_t)(s << 5) + (s >> 11) + *p++; return s; }
static uint16_t xorshift(void) { static uint16_t x = 1; x ^= x << 7; x ^= x >> 9; x ^= x << 8; return x; }
static uint8_t next(void) { uint8_t bit = lfsr & 1; lfsr >>= 1; if (bit) lfsr ^= 0xB8; return lfsr; }
static uint8_t good;
void setup() {
    uint8_t a = 250, i, period = 0;
    uint16_t then = 65530, now = 4;
    a += 10;
    int8_t s = 127; s++;
    do { period++; } while (next() != 0xB5);
    static const uint8_t text[5] = "hello";
    uint16_t last = 0;
    for (i = 0; i < 10; i++) last = xorshift();
    uint8_t down = 0; down--;
    good = a == 4 && (uint16_t)(now - then) == 10 && s == -128 && period == 255 && crc_like(text, 5) == 0x44A3 && last != 0 && down == 255;
}
void loop() { set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
