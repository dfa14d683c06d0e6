/* 1 KB for each robot whose program includes this, and the variables that it places there. They survive a reset of the
   robot, as its id and calibration do, which are where its library keeps them. Erased bytes read 0xFF. */
#ifndef ARKMESH_AVR_EEPROM_H
#define ARKMESH_AVR_EEPROM_H
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "kilolib.h"

/* Variables placed there lie elsewhere, and are recognised because their addresses are no EEPROM's. */
#define EEMEM __attribute__((section(".arkmesh_eeprom")))
#define E2END 0x3FF
#define eeprom_is_ready() 1
#define eeprom_busy_wait() \
  do {                     \
  } while (0)

/* One for all files of a program. Inverted, so that zero is erased. */
__attribute__((section(".arkmesh_eeprom"), visibility("hidden"), weak)) uint8_t arkmesh_eeprom[1024] = {0};

static inline uint8_t eeprom_read_byte(const uint8_t* at) {
  const uintptr_t place = (uintptr_t)at;
  if (place >= sizeof arkmesh_eeprom) return *at;
  return (uint8_t)~arkmesh_eeprom[place];
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
