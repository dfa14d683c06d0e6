/* What programs of simulated Thymios have beside kilolib.h. */
#ifndef ARKMESH_THYMIO_H
#define ARKMESH_THYMIO_H

#include <stdint.h>

#pragma GCC visibility push(hidden)
/* Aseba's prox.horizontal[sensor]: 0 to 4 in front, from left to right, 5 and 6 behind. 0: nothing; 4505: touching. */
int16_t thymio_prox(uint8_t sensor);
#pragma GCC visibility pop

#endif
