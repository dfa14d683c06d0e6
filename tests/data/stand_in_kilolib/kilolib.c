#include "kilolib.h"

#include <avr/io.h>

message_rx_t kilo_message_rx;
message_tx_t kilo_message_tx;
volatile uint32_t kilo_ticks;
uint16_t kilo_uid;
uint8_t kilo_turn_left, kilo_turn_right, kilo_straight_left, kilo_straight_right;

void message_sent(void);

void kilo_init(void) {
  kilo_ticks = 0;
}
#ifndef BOOTLOADER
void kilo_start(void (*setup)(void), void (*loop)(void)) {
  setup();
  for (;;) {
    loop();
    if (kilo_message_tx && kilo_message_tx()) message_sent();
  }
}
#endif
void set_motors(uint8_t left, uint8_t right) {
  OCR2A = left;
  OCR2B = right;
}
void set_color(uint8_t colour) {
  DDRD = colour;
}
void spinup_motors(void) {}
uint8_t rand_hard(void) {
  return TCNT0;
}
void delay(uint16_t ms) {
  while (ms--) kilo_ticks++;
}
