#ifndef STAND_IN_MESSAGE_H
#define STAND_IN_MESSAGE_H
#include <stdint.h>

enum { NORMAL = 0 };

typedef struct {
  uint8_t data[9];
  uint8_t type;
  uint16_t crc;
} message_t;
typedef struct {
  int16_t low_gain, high_gain;
} distance_measurement_t;
#endif
