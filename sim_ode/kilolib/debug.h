/* The serial line of a robot: text is written only by programs that define DEBUG before they include this, and takes
   its time once debug_init() was called. */
#ifndef __DEBUG_H__
#define __DEBUG_H__

#ifdef DEBUG
#include <stdio.h>
#pragma GCC visibility push(hidden)
void arkmesh_serial_on(void);
#pragma GCC visibility pop
static inline void debug_init() {
  arkmesh_serial_on();
}
#else
#define debug_init()
#define printf(...)
#endif
/* ARGoS's debug fields, which nobody reads here; arkmesh_say.h has a way to the lab. */
#define debug_info_create()
#define debug_info_destroy()
#define debug_info_get(field)
#define debug_info_set(field, value)
#define debug_print(...)

#endif
