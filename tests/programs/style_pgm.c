/* Style: everything constant lies in flash: tables of bytes, words, floats, strings and pointers to them, read with the macros for it. */
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <stdio.h>
#include <kilolib.h>
const uint8_t sine[16] PROGMEM = { 0, 24, 48, 70, 89, 105, 117, 124, 127, 124, 117, 105, 89, 70, 48, 24 };
const uint16_t words[] PROGMEM = { 1000, 65535 };
const int16_t negative[] PROGMEM = { -5 };
const float fractions[] PROGMEM = { 0.5, 0.25 };
const char name_a[] PROGMEM = "alpha";
const char name_b[] PROGMEM = "beta";
PGM_P const names[] PROGMEM = { name_a, name_b };
typedef struct { uint8_t left, right; uint16_t ticks; } move_t;
const move_t dance[] PROGMEM = { { 70, 0, 32 }, { 0, 70, 32 } };
static uint8_t good = 1;
void setup() {
    char text[16];
    move_t now;
    uint16_t sum = 0;
    for (uint8_t i = 0; i < sizeof sine; i++) sum += pgm_read_byte(&sine[i]);
    good &= sum == 1281;
    good &= pgm_read_word(&words[1]) == 65535 && (int16_t)pgm_read_word(&negative[0]) == -5;
    good &= pgm_read_float(&fractions[1]) == 0.25;
    strcpy_P(text, (PGM_P)pgm_read_ptr(&names[1]));
    good &= strcmp(text, "beta") == 0 && strcmp_P("alpha", name_a) == 0 && strlen_P(name_a) == 5;
    memcpy_P(&now, &dance[1], sizeof now);
    good &= now.right == 70;
    sprintf_P(text, PSTR("%d-%s"), 7, "x");
    good &= strcmp(text, "7-x") == 0;
    good &= pgm_read_byte_near(sine + 1) == 24;
}
void loop() { set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
