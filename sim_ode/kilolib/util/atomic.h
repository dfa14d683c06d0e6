/* Nothing interrupts a simulated robot's statements: the blocks are blocks. */
#ifndef ARKMESH_UTIL_ATOMIC_H
#define ARKMESH_UTIL_ATOMIC_H
#define ATOMIC_RESTORESTATE
#define ATOMIC_FORCEON
#define NONATOMIC_RESTORESTATE
#define NONATOMIC_FORCEOFF
#define ATOMIC_BLOCK(how) for (int arkmesh_once = 1; arkmesh_once; arkmesh_once = 0)
#define NONATOMIC_BLOCK(how) ATOMIC_BLOCK(how)
#endif
