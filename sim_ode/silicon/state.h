/* What emulator.c holds: the log, the processor, what differs so far. A part of it, with its own includes. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <simavr/avr_eeprom.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_interrupts.h>
#include <simavr/sim_io.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { CALL = 0xE0, NEXT = 0xE1, VALUE = 0xE2, FROM = 0xE6, KIND = 0xE8, INTERRUPTS = 0xFF };
enum { most_causes = 60, most_leaves = 8192, painted = 0xC5, library_rest = 14, text_size = 160 };
static const avr_cycle_count_t tick_cycles = 262144, quiet_cycles = 40000, wait_cycles = 4000, hung_cycles = 80000000;

typedef struct {
  unsigned here, here_size, there, there_size;
  char type;
} Leaf;
static Leaf leaves[most_leaves];
static int leaf_count;

/* Where the library's own variables are; 0: the program has none such. */
static unsigned at_ticks, at_uid, at_duties[4], at_high, at_low, at_message, at_distance, at_brk, heap_start;

static avr_t* avr;
static avr_int_vector_t interrupt_vector;
static FILE* out;
static uint8_t *log_begin, *log_end, *rec, *powered; /* rec: the next record; powered: the last power-up */
static uint8_t image[65536];                         /* the simulated robot's memory */
static int robot;
static uint32_t tick;

/* The stretch of program between two answers to '?'. */
static struct {
  avr_cycle_count_t begin, loop_begin, last_call;
  long segment; /* offset in the log */
  char called;  /* what the outermost call is */
  int depth, outermost, lost, waits, waits_on,
      begun;     /* lost: it has left the log's path, up to the end of the present call */
  int amid;      /* 1 + depth of the call amid which it waits; 0: none */
  uint8_t* skip; /* where the log goes on then */
} now;
typedef struct {
  uint8_t data[0x4100];
  uint8_t sreg[8];
  avr_flashaddr_t pc;
  avr_cycle_count_t cycle;
  avr_int_table_t interrupts;
  uint8_t* rec;
  typeof(now) state;
  uint32_t tick;
} Moment;
static Moment segment, top;
static uint8_t amid[most_leaves]; /* numbers that differed when that wait began */

/* What differs in the present segment. */
static struct {
  char output[2][text_size]; /* on the robot, in simulation; empty: nothing */
  unsigned from;
  avr_cycle_count_t at;
  int count, leaf[most_leaves]; /* numbers that differ at its end */
  int failed;                   /* 'x' crashed, 'h' never returns, 'm' memory, 'l' long */
  unsigned failed_at;
  avr_cycle_count_t cycles;
} seen;
static int compares;   /* numbers are looked at, and set to what they should be */
static int finished;   /* with what the log says, or with the part of it that is repeated */
static int child = -1; /* descriptor to which a copy of this process says where a difference shows first */
static unsigned lowest_stack, highest_heap;
static avr_cycle_count_t longest, budget; /* of a robot */

typedef struct {
  char kind;
  unsigned from;
  int leaf;
  long count;
} Cause;
static Cause causes[most_causes];
static int cause_count;

static unsigned get(const uint8_t* at, int size) {
  unsigned value = 0;
  while (size-- > 0) value = value << 8 | at[size];
  return value;
}
static void put(unsigned address, unsigned value, int size) {
  if (!address) return;
  for (; size-- > 0; value >>= 8) avr->data[address++] = (uint8_t)value;
}
static void copy(unsigned address, const void* from, size_t size) {
  if (address) memcpy(avr->data + address, from, size);
}
static void give_up(const char* what, const char* name) {
  fprintf(stderr, "emulator: %s %s\n", what, name);
  exit(2);
}
