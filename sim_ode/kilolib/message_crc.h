/* The checksum that a program computes for each message it sends; receivers drop a message whose checksum is wrong. */
#ifndef __MESSAGE_CRC_H__
#define __MESSAGE_CRC_H__

#include "message.h"

#pragma GCC visibility push(hidden)
uint16_t message_crc(const message_t* msg);
#pragma GCC visibility pop

#endif
