#include "kilolib.h"

uint16_t message_crc(const message_t* message) {
  return message->data[0];
}
