/* Style: reaches past the library: port bits, the counter of the timer as a source of chance, the status register saved round a critical
   section, atomic blocks, the watchdog fed, idle sleep. Green when nothing went wrong. */
#include <avr/io.h>
#include <avr/interrupt.h>
#include <avr/wdt.h>
#include <avr/sleep.h>
#include <avr/power.h>
#include <util/atomic.h>
#include <util/delay.h>
#include <util/crc16.h>
#include <kilolib.h>
#ifndef F_CPU
#error "F_CPU is set by the robot's makefile"
#endif
static volatile uint16_t shared;
static uint8_t good = 1, seen[8];
void setup() {
    uint8_t sreg = SREG, i;
    DDRB |= (1 << PB1) | _BV(PB2);
    PORTB |= 1 << 1;
    PORTB &= ~_BV(2);
    good &= bit_is_set(PORTB, 1) && bit_is_clear(PORTB, 2);
    cli();
    shared = 1234;
    SREG = sreg;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { shared++; }
    good &= shared == 1235;
    rand_seed(TCNT0 ^ TCNT1);
    for (i = 0; i < 8; i++) { seen[i] = TCNT0; _delay_us(500); }
    good &= seen[0] != seen[4] || seen[1] != seen[7];
    good &= _crc16_update(0xFFFF, 1) == 0x807E;
    wdt_disable();
    set_sleep_mode(SLEEP_MODE_IDLE);
}
void loop() {
    wdt_reset();
    _delay_ms(10);
    sleep_mode();
    asm volatile("nop");
    set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0));
}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
