/* What the robot's compiler knows by itself and a program may call. */
#ifndef ARKMESH_AVR_BUILTINS_H
#define ARKMESH_AVR_BUILTINS_H
#include <util/delay_basic.h>
#define __builtin_avr_nop() ((void)0)
#define __builtin_avr_sei() ((void)0)
#define __builtin_avr_cli() ((void)0)
#define __builtin_avr_wdr() ((void)0)
#define __builtin_avr_swap(byte) ((uint8_t)((uint8_t)(byte) << 4 | (uint8_t)(byte) >> 4))
#define __builtin_avr_delay_cycles(cycles) arkmesh_wait_us((uint32_t)((cycles) / 8))
#endif
