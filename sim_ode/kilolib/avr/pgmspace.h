/* Constants in flash are ordinary constants here. */
#ifndef ARKMESH_AVR_PGMSPACE_H
#define ARKMESH_AVR_PGMSPACE_H
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#define PROGMEM
#define PGM_P const char*
#define PGM_VOID_P const void*
#define PSTR(s) (s)
typedef void prog_void;
typedef char prog_char;
typedef unsigned char prog_uchar;
typedef int8_t prog_int8_t;
typedef uint8_t prog_uint8_t;
typedef int16_t prog_int16_t;
typedef uint16_t prog_uint16_t;
typedef int32_t prog_int32_t;
typedef uint32_t prog_uint32_t;
typedef int64_t prog_int64_t;
typedef uint64_t prog_uint64_t;
#define pgm_read_byte(p) (*(const uint8_t*)(p))
#define pgm_read_word(p) (*(const uint16_t*)(p))
#define pgm_read_dword(p) (*(const uint32_t*)(p))
#define pgm_read_float(p) (*(const float*)(p))
#define pgm_read_ptr(p) (*(void* const*)(p))
#define pgm_read_byte_near(p) pgm_read_byte(p)
#define pgm_read_word_near(p) pgm_read_word(p)
#define pgm_read_dword_near(p) pgm_read_dword(p)
#define pgm_read_float_near(p) pgm_read_float(p)
#define pgm_read_ptr_near(p) pgm_read_ptr(p)
#define pgm_read_byte_far(p) pgm_read_byte(p)
#define pgm_read_word_far(p) pgm_read_word(p)
#define pgm_read_dword_far(p) pgm_read_dword(p)
#define memchr_P memchr
#define memcmp_P memcmp
#define memcpy_P memcpy
#define memmem_P memmem
#define strcasecmp_P strcasecmp
#define strcat_P strcat
#define strchr_P strchr
#define strcmp_P strcmp
#define strcpy_P strcpy
#define strcspn_P strcspn
#define strlcat_P strlcat
#define strlcpy_P strlcpy
#define strlen_P strlen
#define strncasecmp_P strncasecmp
#define strncat_P strncat
#define strncmp_P strncmp
#define strncpy_P strncpy
#define strnlen_P strnlen
#define strpbrk_P strpbrk
#define strrchr_P strrchr
#define strspn_P strspn
#define strstr_P strstr
#define printf_P printf
#define fprintf_P fprintf
#define sprintf_P sprintf
#define snprintf_P snprintf
#define vsnprintf_P vsnprintf
#define sscanf_P sscanf
#define vprintf_P vprintf
#define vfprintf_P vfprintf
#define vsprintf_P vsprintf
#define fscanf_P fscanf
#define strtok_P strtok
#define strtok_rP strtok_r
#define strsep_P strsep
#define memccpy_P memccpy
#define memrchr_P memrchr
#define strchrnul_P strchrnul
#define strcasestr_P strcasestr
#define pgm_get_far_address(name) (&(name))
#define puts_P puts
#define fputs_P fputs
#endif
