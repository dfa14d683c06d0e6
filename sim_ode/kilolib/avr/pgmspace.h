/* Constants in flash are ordinary constants here. */
#ifndef ARKMESH_AVR_PGMSPACE_H
#define ARKMESH_AVR_PGMSPACE_H
#include <stdint.h>
#include <string.h>
#define PROGMEM
#define PSTR(s) (s)
#define pgm_read_byte(p) (*(const uint8_t *)(p))
#define pgm_read_word(p) (*(const uint16_t *)(p))
#define pgm_read_dword(p) (*(const uint32_t *)(p))
#define memcpy_P memcpy
#define strcpy_P strcpy
#endif
