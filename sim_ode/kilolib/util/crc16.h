/* Check sums of the robot's C library, bit by bit. */
#ifndef ARKMESH_UTIL_CRC16_H
#define ARKMESH_UTIL_CRC16_H
#include <stdint.h>
static inline uint16_t arkmesh_crc_down(uint16_t crc, uint8_t byte, uint16_t polynomial) {
  crc ^= byte;
  for (int i = 0; i < 8; i++) crc = crc & 1 ? crc >> 1 ^ polynomial : crc >> 1;
  return crc;
}
static inline uint16_t _crc16_update(uint16_t crc, uint8_t byte) {
  return arkmesh_crc_down(crc, byte, 0xA001);
}
static inline uint16_t _crc_ccitt_update(uint16_t crc, uint8_t byte) {
  return arkmesh_crc_down(crc, byte, 0x8408);
}
static inline uint8_t _crc_ibutton_update(uint8_t crc, uint8_t byte) {
  return (uint8_t)arkmesh_crc_down(crc, byte, 0x8C);
}
static inline uint8_t _crc8_ccitt_update(uint8_t crc, uint8_t byte) {
  crc ^= byte;
  for (int i = 0; i < 8; i++) crc = crc & 0x80 ? (uint8_t)(crc << 1) ^ 0x07 : (uint8_t)(crc << 1);
  return crc;
}
static inline uint16_t _crc_xmodem_update(uint16_t crc, uint8_t byte) {
  crc ^= (uint16_t)(byte << 8);
  for (int i = 0; i < 8; i++) crc = crc & 0x8000 ? (uint16_t)(crc << 1) ^ 0x1021 : (uint16_t)(crc << 1);
  return crc;
}
#endif
