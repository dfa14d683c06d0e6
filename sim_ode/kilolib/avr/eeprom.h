/* 1 KB for each robot whose program includes this; erased bytes read 0xFF, the robot's id and calibration are where its
   library keeps them. A reset of the robot erases what was written, unlike on the robot. */
#ifndef ARKMESH_AVR_EEPROM_H
#define ARKMESH_AVR_EEPROM_H
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "kilolib.h"

/* Variables placed there are ordinary ones, and recognised because their addresses are no EEPROM's. */
#define EEMEM
#define E2END 0x3FF
#define eeprom_is_ready() 1
#define eeprom_busy_wait() \
  do {                     \
  } while (0)

static uint8_t arkmesh_eeprom[1024]; /* inverted, so that zero is erased */

static inline uint8_t eeprom_read_byte(const uint8_t* at) {
  const uintptr_t place = (uintptr_t)at;
  if (place >= sizeof arkmesh_eeprom) return *at;
  if (arkmesh_eeprom[place]) return (uint8_t)~arkmesh_eeprom[place];
  switch (place) {
    case 0x05:
      return kilo_turn_left;
    case 0x09:
      return kilo_turn_right;
    case 0x0C:
      return kilo_straight_left;
    case 0x14:
      return kilo_straight_right;
    case 0xB0:
      return (uint8_t)kilo_uid;
    case 0xB1:
      return (uint8_t)(kilo_uid >> 8);
  }
  if (place >= 0x20 && place <= 0x3B) return (uint8_t)(kilo_irlow[(place - 0x20) / 2] >> (place % 2 ? 0 : 8));
  if (place >= 0x50 && place <= 0x6B) return (uint8_t)(kilo_irhigh[(place - 0x50) / 2] >> (place % 2 ? 0 : 8));
  return 0xFF;
}
static inline void eeprom_write_byte(uint8_t* at, uint8_t value) {
  const uintptr_t place = (uintptr_t)at;
  if (place >= sizeof arkmesh_eeprom)
    *at = value;
  else
    arkmesh_eeprom[place] = (uint8_t)~value;
}
static inline void eeprom_read_block(void* to, const void* at, size_t size) {
  for (size_t i = 0; i < size; i++) ((uint8_t*)to)[i] = eeprom_read_byte((const uint8_t*)at + i);
}
static inline void eeprom_write_block(const void* from, void* at, size_t size) {
  for (size_t i = 0; i < size; i++) eeprom_write_byte((uint8_t*)at + i, ((const uint8_t*)from)[i]);
}
#define ARKMESH_EEPROM_TYPE(name, type)                           \
  static inline type eeprom_read_##name(const type* at) {         \
    type value;                                                   \
    eeprom_read_block(&value, at, sizeof value);                  \
    return value;                                                 \
  }                                                               \
  static inline void eeprom_write_##name(type* at, type value) {  \
    eeprom_write_block(&value, at, sizeof value);                 \
  }                                                               \
  static inline void eeprom_update_##name(type* at, type value) { \
    eeprom_write_block(&value, at, sizeof value);                 \
  }
ARKMESH_EEPROM_TYPE(word, uint16_t)
ARKMESH_EEPROM_TYPE(dword, uint32_t)
ARKMESH_EEPROM_TYPE(float, float)
static inline void eeprom_update_byte(uint8_t* at, uint8_t value) {
  eeprom_write_byte(at, value);
}
static inline void eeprom_update_block(const void* from, void* at, size_t size) {
  eeprom_write_block(from, at, size);
}
#endif
