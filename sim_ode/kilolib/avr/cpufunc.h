/* Nothing, slowly. */
#ifndef ARKMESH_AVR_CPUFUNC_H
#define ARKMESH_AVR_CPUFUNC_H
#define _NOP() ((void)0)
#define _MemoryBarrier() __asm__ __volatile__("" ::: "memory")
#endif
