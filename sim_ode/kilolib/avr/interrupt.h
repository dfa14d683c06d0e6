/* A simulated robot's interrupts never come between two statements of its program. */
#ifndef ARKMESH_AVR_INTERRUPT_H
#define ARKMESH_AVR_INTERRUPT_H
#define cli() ((void)0)
#define sei() ((void)0)
#endif
