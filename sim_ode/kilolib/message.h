/* The message that robots and the overhead controller send: 12 bytes on the air. */
#ifndef __MESSAGES_H__
#define __MESSAGES_H__
#ifndef __MESSAGE_H__
#define __MESSAGE_H__

#include <stdint.h>

typedef struct {
  uint8_t data[9];
  uint8_t type; /* 0..127 for programs */
  uint16_t crc;
} message_t;

typedef enum {
  NORMAL = 0,
  GPS,
  SPECIAL = 0x80,
  BOOT = 0x80,
  BOOTPGM_PAGE,
  BOOTPGM_SIZE,
  RESET,
  SLEEP,
  WAKEUP,
  CHARGE,
  VOLTAGE,
  RUN,
  READUID,
  CALIB
} message_type_t;

#endif
#endif
