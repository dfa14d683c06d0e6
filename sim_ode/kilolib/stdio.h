/* The C library's own, and streams of the robot's library that a program makes of functions: the serial line, whatever
   their functions are. */
#include_next <stdio.h>
#ifndef ARKMESH_STDIO_H
#define ARKMESH_STDIO_H
#pragma GCC visibility push(hidden)
extern FILE* arkmesh_serial[3];
#pragma GCC visibility pop
#undef stdin
#undef stdout
#undef stderr
#define stdin arkmesh_serial[0]
#define stdout arkmesh_serial[1]
#define stderr arkmesh_serial[2]
#define _FDEV_ERR (-1)
#define _FDEV_EOF (-2)
#define _FDEV_SETUP_READ 1
#define _FDEV_SETUP_WRITE 2
#define _FDEV_SETUP_RW 3
#define FDEV_SETUP_STREAM(put, get, flags) \
  {}
#define fdev_setup_stream(stream, put, get, flags) ((void)(put), (void)(get))
#define fdev_set_udata(stream, data) ((void)(data))
#define fdev_get_udata(stream) ((void*)0)
#define fdev_close() ((void)0)
static inline FILE* fdevopen(int (*put)(char, FILE*), int (*get)(FILE*)) {
  (void)put, (void)get;
  return stdout;
}
#endif
