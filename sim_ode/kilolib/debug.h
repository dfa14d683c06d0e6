/* The serial line of a robot: text is written only by programs that define DEBUG before they include this. */
#ifndef __DEBUG_H__
#define __DEBUG_H__

#ifdef DEBUG
#include <stdio.h>
static inline void debug_init() {}
#else
#define debug_init()
#define printf(...)
#endif

#endif
