/* Stands in for a robot's library where a test builds for the robot: the names are there, nothing moves. */
#ifndef STAND_IN_KILOLIB_H
#define STAND_IN_KILOLIB_H
#include <stdint.h>

#include "message.h"

#define RGB(r, g, b) (r & 3) | (((g & 3) << 2)) | ((b & 3) << 4)

typedef void (*message_rx_t)(message_t*, distance_measurement_t*);
typedef message_t* (*message_tx_t)(void);
extern message_rx_t kilo_message_rx;
extern message_tx_t kilo_message_tx;
extern volatile uint32_t kilo_ticks;
extern uint16_t kilo_uid;
extern uint8_t kilo_turn_left, kilo_turn_right, kilo_straight_left, kilo_straight_right;

void kilo_init(void);
void kilo_start(void (*setup)(void), void (*loop)(void));
void set_motors(uint8_t left, uint8_t right);
void set_color(uint8_t colour);
void spinup_motors(void);
uint8_t rand_hard(void);
void delay(uint16_t ms);
uint16_t message_crc(const message_t* message);
#endif
