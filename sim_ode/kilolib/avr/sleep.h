/* A robot that sleeps until the next interrupt sleeps until the next tick. */
#ifndef ARKMESH_AVR_SLEEP_H
#define ARKMESH_AVR_SLEEP_H
#include "kilolib.h"
#define SLEEP_MODE_IDLE 0
#define SLEEP_MODE_ADC 1
#define SLEEP_MODE_PWR_DOWN 2
#define SLEEP_MODE_PWR_SAVE 3
#define SLEEP_MODE_STANDBY 6
#define SLEEP_MODE_EXT_STANDBY 7
#define set_sleep_mode(mode) ((void)(mode))
#define sleep_enable() ((void)0)
#define sleep_disable() ((void)0)
#define sleep_bod_disable() ((void)0)
#define sleep_cpu() arkmesh_busy()
#define sleep_mode() arkmesh_busy()
#endif
