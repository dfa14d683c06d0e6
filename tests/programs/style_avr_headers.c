/* Style: the headers and macros of the robot's C library that people include out of habit: interrupts off and on, text in flash,
   EEPROM, port bits. Green when all went well. */
#include <avr/io.h>
#include <avr/interrupt.h>
#include <avr/pgmspace.h>
#include <util/delay.h>
#include <kilolib.h>

static const uint8_t table[4] PROGMEM = {1, 2, 4, 8};
static volatile uint8_t sum;

void setup() {
    uint8_t i;
    cli();
    for (i = 0; i < 4; i++) sum += pgm_read_byte(&table[i]);
    sei();
    _delay_ms(20);
}

void loop() {
    set_color(sum == 15 ? RGB(0, 3, 0) : RGB(3, 0, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
