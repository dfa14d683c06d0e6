/* The robot's registers, as far as a simulated robot has them. Ports are bytes that nothing is connected to, but for
   the LED's, which show what it was set to, as the motors' duties do; the timers' counters count, for programs that
   draw chance from them. Whoever uses a register that would move motors,
   light the LED, or read a sensor past the library is told so when the program is compiled. */
#ifndef ARKMESH_AVR_IO_H
#define ARKMESH_AVR_IO_H
#include <stdint.h>

#define _BV(bit) (1 << (bit))
#define bit_is_set(place, bit) ((place)&_BV(bit))
#define bit_is_clear(place, bit) (!((place)&_BV(bit)))
#define loop_until_bit_is_set(place, bit) \
  do {                                    \
  } while (bit_is_clear(place, bit))
#define loop_until_bit_is_clear(place, bit) \
  do {                                      \
  } while (bit_is_set(place, bit))
#define E2END 0x3FF
#define FLASHEND 0x7FFF
#define RAMEND 0x8FF

#pragma GCC visibility push(hidden)
uint8_t* arkmesh_timer(void);
#pragma GCC visibility pop
#define TCNT0 (*arkmesh_timer())
#define TCNT1 (*(uint16_t*)arkmesh_timer())
#define TCNT1L (*arkmesh_timer())
#define TCNT2 (*arkmesh_timer())

/* One for all files of a program; the last two are the motors'. */
__attribute__((visibility("hidden"), weak)) uint8_t arkmesh_registers[20] = {0};
static inline const uint8_t* arkmesh_register_OCR2A(void) {
  return arkmesh_registers + 18;
}
static inline const uint8_t* arkmesh_register_OCR2B(void) {
  return arkmesh_registers + 19;
}
#define OCR2A (*arkmesh_register_OCR2A())
#define OCR2B (*arkmesh_register_OCR2B())
#define PINB arkmesh_registers[0]
#define DDRB arkmesh_registers[1]
#define PORTB arkmesh_registers[2]
#define PINC arkmesh_registers[3]
#define DDRC arkmesh_registers[4]
#define PORTC arkmesh_registers[5]
#define PIND arkmesh_registers[6]
#define DDRD arkmesh_registers[7]
#define PORTD arkmesh_registers[8]
#define SREG arkmesh_registers[9]
#define MCUSR arkmesh_registers[10]
#define MCUCR arkmesh_registers[11]
#define GPIOR0 arkmesh_registers[12]
#define GPIOR1 arkmesh_registers[13]
#define GPIOR2 arkmesh_registers[14]
#define SMCR arkmesh_registers[15]
#define PRR arkmesh_registers[16]
#define CLKPR arkmesh_registers[17]

#define ARKMESH_NO_REGISTER(name)                                                                              \
  (*({                                                                                                         \
    extern volatile uint16_t* arkmesh_without_##name(void)                                                     \
        __attribute__((error("a simulated robot has no register " #name "; use the functions of kilolib.h"))); \
    arkmesh_without_##name();                                                                                  \
  }))
#define ADC ARKMESH_NO_REGISTER(ADC)
#define ADCW ARKMESH_NO_REGISTER(ADCW)
#define ADCL ARKMESH_NO_REGISTER(ADCL)
#define ADCH ARKMESH_NO_REGISTER(ADCH)
#define ADCSRA ARKMESH_NO_REGISTER(ADCSRA)
#define ADCSRB ARKMESH_NO_REGISTER(ADCSRB)
#define ADMUX ARKMESH_NO_REGISTER(ADMUX)
#define ACSR ARKMESH_NO_REGISTER(ACSR)
#define DIDR0 ARKMESH_NO_REGISTER(DIDR0)
#define DIDR1 ARKMESH_NO_REGISTER(DIDR1)
#define TCCR0A ARKMESH_NO_REGISTER(TCCR0A)
#define TCCR0B ARKMESH_NO_REGISTER(TCCR0B)
#define TCCR1A ARKMESH_NO_REGISTER(TCCR1A)
#define TCCR1B ARKMESH_NO_REGISTER(TCCR1B)
#define TCCR1C ARKMESH_NO_REGISTER(TCCR1C)
#define TCCR2A ARKMESH_NO_REGISTER(TCCR2A)
#define TCCR2B ARKMESH_NO_REGISTER(TCCR2B)
#define OCR0A ARKMESH_NO_REGISTER(OCR0A)
#define OCR0B ARKMESH_NO_REGISTER(OCR0B)
#define OCR1A ARKMESH_NO_REGISTER(OCR1A)
#define OCR1B ARKMESH_NO_REGISTER(OCR1B)
#define OCR1AL ARKMESH_NO_REGISTER(OCR1AL)
#define OCR1AH ARKMESH_NO_REGISTER(OCR1AH)
#define OCR1BL ARKMESH_NO_REGISTER(OCR1BL)
#define OCR1BH ARKMESH_NO_REGISTER(OCR1BH)
#define TIMSK0 ARKMESH_NO_REGISTER(TIMSK0)
#define TIMSK1 ARKMESH_NO_REGISTER(TIMSK1)
#define TIMSK2 ARKMESH_NO_REGISTER(TIMSK2)
#define TIFR0 ARKMESH_NO_REGISTER(TIFR0)
#define TIFR1 ARKMESH_NO_REGISTER(TIFR1)
#define TIFR2 ARKMESH_NO_REGISTER(TIFR2)
#define ICR1 ARKMESH_NO_REGISTER(ICR1)
#define GTCCR ARKMESH_NO_REGISTER(GTCCR)
#define ASSR ARKMESH_NO_REGISTER(ASSR)
#define UDR0 ARKMESH_NO_REGISTER(UDR0)
#define UCSR0A ARKMESH_NO_REGISTER(UCSR0A)
#define UCSR0B ARKMESH_NO_REGISTER(UCSR0B)
#define UCSR0C ARKMESH_NO_REGISTER(UCSR0C)
#define UBRR0 ARKMESH_NO_REGISTER(UBRR0)
#define UBRR0L ARKMESH_NO_REGISTER(UBRR0L)
#define UBRR0H ARKMESH_NO_REGISTER(UBRR0H)
#define SPCR ARKMESH_NO_REGISTER(SPCR)
#define SPSR ARKMESH_NO_REGISTER(SPSR)
#define SPDR ARKMESH_NO_REGISTER(SPDR)
#define TWBR ARKMESH_NO_REGISTER(TWBR)
#define TWSR ARKMESH_NO_REGISTER(TWSR)
#define TWAR ARKMESH_NO_REGISTER(TWAR)
#define TWDR ARKMESH_NO_REGISTER(TWDR)
#define TWCR ARKMESH_NO_REGISTER(TWCR)
#define PCICR ARKMESH_NO_REGISTER(PCICR)
#define PCIFR ARKMESH_NO_REGISTER(PCIFR)
#define PCMSK0 ARKMESH_NO_REGISTER(PCMSK0)
#define PCMSK1 ARKMESH_NO_REGISTER(PCMSK1)
#define PCMSK2 ARKMESH_NO_REGISTER(PCMSK2)
#define EICRA ARKMESH_NO_REGISTER(EICRA)
#define EIMSK ARKMESH_NO_REGISTER(EIMSK)
#define EIFR ARKMESH_NO_REGISTER(EIFR)
#define OSCCAL ARKMESH_NO_REGISTER(OSCCAL)
#define WDTCSR ARKMESH_NO_REGISTER(WDTCSR)
#define EECR ARKMESH_NO_REGISTER(EECR)
#define EEDR ARKMESH_NO_REGISTER(EEDR)
#define EEAR ARKMESH_NO_REGISTER(EEAR)
#define EEARL ARKMESH_NO_REGISTER(EEARL)
#define EEARH ARKMESH_NO_REGISTER(EEARH)
#define SPMCSR ARKMESH_NO_REGISTER(SPMCSR)

/* Bits. */
enum {
  PB0 = 0,
  PORTB0 = 0,
  DDB0 = 0,
  PINB0 = 0,
  PB1 = 1,
  PORTB1 = 1,
  DDB1 = 1,
  PINB1 = 1,
  PB2 = 2,
  PORTB2 = 2,
  DDB2 = 2,
  PINB2 = 2,
  PB3 = 3,
  PORTB3 = 3,
  DDB3 = 3,
  PINB3 = 3,
  PB4 = 4,
  PORTB4 = 4,
  DDB4 = 4,
  PINB4 = 4,
  PB5 = 5,
  PORTB5 = 5,
  DDB5 = 5,
  PINB5 = 5,
  PB6 = 6,
  PORTB6 = 6,
  DDB6 = 6,
  PINB6 = 6,
  PB7 = 7,
  PORTB7 = 7,
  DDB7 = 7,
  PINB7 = 7
};
enum {
  PC0 = 0,
  PORTC0 = 0,
  DDC0 = 0,
  PINC0 = 0,
  PC1 = 1,
  PORTC1 = 1,
  DDC1 = 1,
  PINC1 = 1,
  PC2 = 2,
  PORTC2 = 2,
  DDC2 = 2,
  PINC2 = 2,
  PC3 = 3,
  PORTC3 = 3,
  DDC3 = 3,
  PINC3 = 3,
  PC4 = 4,
  PORTC4 = 4,
  DDC4 = 4,
  PINC4 = 4,
  PC5 = 5,
  PORTC5 = 5,
  DDC5 = 5,
  PINC5 = 5,
  PC6 = 6,
  PORTC6 = 6,
  DDC6 = 6,
  PINC6 = 6,
  PC7 = 7,
  PORTC7 = 7,
  DDC7 = 7,
  PINC7 = 7
};
enum {
  PD0 = 0,
  PORTD0 = 0,
  DDD0 = 0,
  PIND0 = 0,
  PD1 = 1,
  PORTD1 = 1,
  DDD1 = 1,
  PIND1 = 1,
  PD2 = 2,
  PORTD2 = 2,
  DDD2 = 2,
  PIND2 = 2,
  PD3 = 3,
  PORTD3 = 3,
  DDD3 = 3,
  PIND3 = 3,
  PD4 = 4,
  PORTD4 = 4,
  DDD4 = 4,
  PIND4 = 4,
  PD5 = 5,
  PORTD5 = 5,
  DDD5 = 5,
  PIND5 = 5,
  PD6 = 6,
  PORTD6 = 6,
  DDD6 = 6,
  PIND6 = 6,
  PD7 = 7,
  PORTD7 = 7,
  DDD7 = 7,
  PIND7 = 7
};
enum {
  ADPS0 = 0,
  ADPS1 = 1,
  ADPS2 = 2,
  ADIE = 3,
  ADIF = 4,
  ADATE = 5,
  ADSC = 6,
  ADEN = 7,
  MUX0 = 0,
  MUX1 = 1,
  MUX2 = 2,
  MUX3 = 3,
  ADLAR = 5,
  REFS0 = 6,
  REFS1 = 7,
  CS00 = 0,
  CS01 = 1,
  CS02 = 2,
  CS10 = 0,
  CS11 = 1,
  CS12 = 2,
  CS20 = 0,
  CS21 = 1,
  CS22 = 2,
  TOIE0 = 0,
  OCIE0A = 1,
  OCIE0B = 2,
  TOIE1 = 0,
  TOIE2 = 0,
  OCIE1A = 1,
  WGM00 = 0,
  WGM01 = 1,
  RXEN0 = 4,
  TXEN0 = 3,
  UDRE0 = 5,
  RXC0 = 7,
  TXC0 = 6,
  ACO = 5,
  ACD = 7,
  SM0 = 1,
  SM1 = 2,
  SM2 = 3,
  SE = 0,
  PORF = 0,
  EXTRF = 1,
  BORF = 2,
  WDRF = 3
};
#endif
