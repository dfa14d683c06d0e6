/* Optional buffers between the library and a program: 16 received messages with their distances, 4 to send. */
#ifndef __MESSAGE_BUFFERED_H__
#define __MESSAGE_BUFFERED_H__

#include "kilolib.h"
#include "ringbuffer.h"

#ifndef RXBUFFER_SIZE
#define RXBUFFER_SIZE 16
#endif
#ifndef TXBUFFER_SIZE
#define TXBUFFER_SIZE 4
#endif

typedef struct {
  message_t msg;
  distance_measurement_t dist;
} received_message_t;

RB_create(rxbuffer, received_message_t, RXBUFFER_SIZE);
RB_create(txbuffer, message_t, TXBUFFER_SIZE);

static inline uint8_t rxbuffer_size() {
  return RB_size(rxbuffer);
}
static inline void rxbuffer_push(message_t* msg, distance_measurement_t* dist) {
  RB_back(rxbuffer).msg = *msg;
  RB_back(rxbuffer).dist = *dist;
  RB_pushback(rxbuffer);
}
/* The oldest message, null when there is none. */
static inline message_t* rxbuffer_peek(distance_measurement_t* dist) {
  if (RB_empty(rxbuffer)) return 0;
  *dist = RB_front(rxbuffer).dist;
  return &RB_front(rxbuffer).msg;
}
static inline void rxbuffer_pop() {
  if (!RB_empty(rxbuffer)) RB_popfront(rxbuffer);
}

static inline uint8_t txbuffer_size() {
  return RB_size(txbuffer);
}
static inline void txbuffer_push(message_t* msg) {
  RB_back(txbuffer) = *msg;
  RB_pushback(txbuffer);
}
static inline message_t* txbuffer_peek() {
  return RB_empty(txbuffer) ? 0 : &RB_front(txbuffer);
}
static inline void txbuffer_pop() {
  if (!RB_empty(txbuffer)) RB_popfront(txbuffer);
}

/* Puts the buffers between the library and the program. */
static inline void kilo_message_buffered() {
  RB_init(rxbuffer);
  RB_init(txbuffer);
  kilo_message_rx = rxbuffer_push;
  kilo_message_tx = txbuffer_peek;
  kilo_message_tx_success = txbuffer_pop;
}

#endif
