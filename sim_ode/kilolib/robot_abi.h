// What a compiled robot program and the simulator know of each other. C and C++; pointers only, because the two sides
// are compiled with different rules for structures.
#ifndef ARKMESH_ROBOT_ABI_H
#define ARKMESH_ROBOT_ABI_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

// The mathematics that a program may call, of one number and of two.
#define ARKMESH_MATHEMATICS(OF_ONE, OF_TWO) \
  OF_ONE(sin)                               \
  OF_ONE(cos)                               \
  OF_ONE(tan)                               \
  OF_ONE(asin)                              \
  OF_ONE(acos)                              \
  OF_ONE(atan)                              \
  OF_ONE(sinh)                              \
  OF_ONE(cosh)                              \
  OF_ONE(tanh)                              \
  OF_ONE(exp)                               \
  OF_ONE(exp2)                              \
  OF_ONE(log)                               \
  OF_ONE(log2)                              \
  OF_ONE(log10)                             \
  OF_ONE(cbrt)                              \
  OF_TWO(atan2)                             \
  OF_TWO(pow)                               \
  OF_TWO(hypot)

// What the simulator does for the robot whose turn it is. Filled in once after loading; not part of a robot's memory.
struct arkmesh_host {
  void (*wait_us)(uint32_t us, const void* from);  // lets the robot's time pass; `from` asked for it, perhaps null
  void (*wait_for_tick)(const void* from);         // until the next tick; `from` has asked for the time often
  void (*motors)(uint8_t left, uint8_t right);
  void (*colour)(uint8_t colour);
  int16_t (*light)(void);
  int16_t (*voltage)(void);
  int16_t (*temperature)(void);
  uint8_t (*random_byte)(void);
  void (*text)(const char* text, uint32_t size);     // printed on the serial line
  void (*started)(void);                             // kilo_start was called; does not return
  void (*ended)(const char* why, const void* from);  // the program gave up; does not return
  void (*busy_at)(
      const void* from,
      int wakeable);  // it has computed for about a tick; it has callbacks that may change what it waits for
  void (*jumps)(const void* from);  // longjmp is called; does not return from inside a callback
  // The robot's heap, as realloc(); 0 bytes: as free(). Null: it has no room.
  void* (*reallocate)(void* old, size_t size, const void* from);
  // The robot's files. The stream of another one, the serial line's among them: -1, and nothing is done.
  FILE* (*open)(const char* name, const char* mode);
  int (*close)(FILE* stream);
  int (*write)(FILE* stream, const void* data, size_t size);  // and flushes
  int (*print)(FILE* stream, const char* format, va_list values);
  // The C library's own vsnprintf, vsscanf and vfscanf.
  int (*format)(char* to, size_t room, const char* format, va_list values);
  int (*scan)(const char* text, const char* format, va_list values);
  int (*scan_file)(FILE* stream, const char* format, va_list values);
  void (*say)(uint8_t kind, int32_t value, const void* from);  // to the lab
  int16_t (*prox)(uint8_t sensor, const void* from);
#define OF_ONE(name) double (*name)(double);
#define OF_TWO(name) double (*name)(double, double);
  ARKMESH_MATHEMATICS(OF_ONE, OF_TWO)
#undef OF_ONE
#undef OF_TWO
};

// What the simulator uses of a program.
struct arkmesh_program {
  char *begin, *end;                // all writable memory of a robot
  char* own;                        // where in it the program's own variables begin
  char *eeprom_begin, *eeprom_end;  // of it, what survives a reset
  uint8_t* eeprom;                  // 1 KB of that by address, inverted; null: the program does not use it
  struct arkmesh_host* host;
  int (*main)(void);
  void (**setup)(void);
  void (**loop)(void);
  void (**rx)(void* message, void* distance);
  void* (**tx)(void);
  void* (*no_tx)(void);  // what *tx is while the program has not set it
  void (**tx_success)(void);
  void* rx_message;      // 12 bytes: data, type, crc
  int16_t* rx_distance;  // low gain, high gain
  uint8_t* measured;     // estimate_distance() was called
  volatile uint32_t* ticks;
  uint32_t* reads;  // of the clock or a sensor since the program last got time
  uint32_t*
      blocks;  // parts of a tick's work that it did since it last got time; work_per_tick of robot_parts.h make a tick
  uint16_t* uid;
  volatile uint16_t* tx_period;
  uint8_t *turn_left, *turn_right, *straight_left, *straight_right;
  uint16_t *irhigh, *irlow;
  uint8_t (*back_off)(void);  // of a robot that found the channel busy; in counts of its timer, 128 microseconds each
  uint8_t* registers;         // of avr/io.h, the motors' duties being 18 and 19; null: it does not use them
  const char* pc_types;       // why it was compiled with a PC's types; null: with a robot's
};

#endif
