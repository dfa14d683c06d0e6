/* A robot's program on the robot's own processor (simavr), fed with what a simulated robot got, and compared with what
   that one did. A process of its own, compiled at first use, because simavr has another licence than arkmesh. Knows
   nothing of names: proof.cpp makes words of what it writes.

   emulator OUT MCU PROGRAM.bin HEAP_START BRKVAL TABLE CYCLES LOG...

   TABLE, a line for each number in the program's memory: HERE SIZE THERE SIZE TYPE, an address on the processor and an
   offset in the simulated robot's memory; TYPE is s, u or f. LOGs are turn_log.hpp's, a robot each; all together run
   for CYCLES at most.

   A log's records, numbers little endian:
   I id duties tables EEPROM   power-up          s memory    kilo_start() was called
   k tick kilo_ticks           time has come     v id duties a command has set these
   S L X T U B                 setup, loop, received (message, low, high), to send, sent, backed off: called
   R size result memory        returned
   m left right  c colour  y kind value          outputs
   l o e value  h value                          light, voltage, temperature; rand_hard
   d microseconds memory ... D  delay and its end, with what came between; w ... W  a wait without a call
   F                           the program is forgotten, until power-up

   OUT gets: `cause`, a tick's difference, once for each place; `check` of the compiler's own checks; `robot` figures.
 */
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

/* ---- the log ---- */

static uint8_t* after_memory(uint8_t* at) {
  while (get(at + 2, 2) > 0) at += 4 + get(at + 2, 2);
  return at + 4;
}
static uint8_t* after(uint8_t* at) {
  switch (*at) {
    case 'I':
      return at + 1 + 6 + 56 + 1024;
    case 's':
      return after_memory(at + 1);
    case 'k':
      return at + 9;
    case 'v':
      return at + 7;
    case 'X':
      return at + 17;
    case 'R':
      return after_memory(at + 2 + at[1]);
    case 'd':
      return after_memory(at + 5);
    case 'y':
      return at + 6;
    case 'm':
    case 'l':
    case 'o':
    case 'e':
      return at + 3;
    case 'c':
    case 'h':
      return at + 2;
    default:
      return at + 1;
  }
}
static int begins(char letter) {
  return letter && strchr("SLXTUB", letter) != 0;
}
static void take_memory(const uint8_t* at) {
  for (; get(at + 2, 2) > 0; at += 4 + get(at + 2, 2)) memcpy(image + get(at, 2), at + 4, get(at + 2, 2));
}
static void take_values(const uint8_t* at) {
  int i;
  put(at_uid, get(at, 2), 2);
  for (i = 0; i < 4; i++) put(at_duties[i], at[2 + i], 1);
}
/* The record that ends the present call; what happens meanwhile is done to the memory. */
static uint8_t* end_of_call(uint8_t* at, int deep) {
  for (; at < log_end && *at != 'F' && *at != 'I'; at = after(at)) {
    if (*at == 'k') tick = get(at + 1, 4), put(at_ticks, get(at + 5, 4), 4);
    if (*at == 'v') take_values(at + 1);
    if (*at == 'd') take_memory(at + 5);
    if (begins((char)*at)) deep++;
    if (*at == 'R') {
      if (deep-- == 0) return at;
      take_memory(at + 2 + at[1]);
    }
  }
  return at;
}
static void take_time(void) {
  for (; rec < log_end && (*rec == 'k' || *rec == 'v'); rec = after(rec))
    if (*rec == 'v')
      take_values(rec + 1);
    else
      tick = get(rec + 1, 4), put(at_ticks, get(rec + 5, 4), 4);
}

/* ---- numbers ---- */

static double number(const uint8_t* at, int size, char type) {
  const unsigned value = get(at, size > 4 ? 4 : size);
  if (type == 'f') {
    float single;
    double twice;
    memcpy(&single, at, 4);
    if (size == 8) memcpy(&twice, at, 8);
    return size == 8 ? twice : single;
  }
  if (type == 's') return size == 1 ? (int8_t)value : size == 2 ? (int16_t)value : (int32_t)value;
  return value;
}
static int differs(const Leaf* leaf) {
  const uint8_t *here = avr->data + leaf->here, *there = image + leaf->there;
  float a, b;
  if (leaf->here_size == leaf->there_size && memcmp(here, there, leaf->here_size) == 0) return 0;
  if (leaf->type != 'f')
    return number(here, leaf->here_size, leaf->type) != number(there, leaf->there_size, leaf->type);
  a = (float)number(here, 4, 'f'), b = (float)number(there, leaf->there_size, 'f');
  /* 8 steps of the last digit; what is left of a difference, or of a large angle's sine, counts as 0 below 1e-5 */
  return !(isnan(a) && isnan(b)) && a != b && !(fabsf(a - b) <= 8 * fmaxf(fabsf(a), fabsf(b)) * 1.2e-7f + 1e-5f);
}
static void become(const Leaf* leaf) {
  const uint8_t* there = image + leaf->there;
  if (leaf->type == 'f') {
    const float value = (float)number(there, leaf->there_size, 'f');
    copy(leaf->here, &value, 4);
  } else {
    put(leaf->here, get(there, leaf->there_size > 4 ? 4 : leaf->there_size), leaf->here_size);
  }
}
static void compare(void) {
  int i;
  if (!compares || child >= 0) return;
  for (i = 0; i < leaf_count; i++)
    if (differs(leaves + i)) seen.leaf[seen.count++] = i;
}

/* ---- what a program says ---- */

static void say(char* to, char letter, unsigned a, const uint8_t* message) {
  switch (letter) {
    case 'm':
      sprintf(to, "set_motors(%u, %u)", a & 255, a >> 8 & 255);
      break;
    case 'c':
      sprintf(to, "set_color(%u)", a & 255);
      break;
    case 'y':
      sprintf(to, "arkmesh_say(%u, %d)", message[0], (int)a);
      break;
    case 'd':
      sprintf(to, "delay of %u.%03u ms", a / 1000, a % 1000);
      break;
    case 'R':
      sprintf(to, now.called == 'L'   ? "the end of loop"
                  : now.called == 'S' ? "the end of setup"
                                      : "the end of a callback");
      break;
    case 'M': {
      int i;
      to += sprintf(to, "message");
      for (i = 0; i < 10; i++) to += sprintf(to, " %u", message[i]);
      break;
    }
    default:
      sprintf(to, "%s",
              letter == 'l'   ? "get_ambientlight()"
              : letter == 'o' ? "get_voltage()"
              : letter == 'e' ? "get_temperature()"
              : letter == 'h' ? "rand_hard()"
              : letter == 'w' ? "a wait"
                              : "nothing");
  }
}
static void say_record(char* to, const uint8_t* at) {
  if (at >= log_end) return say(to, 0, 0, 0);
  say(to, (char)*at,
      *at == 'm'   ? get(at + 1, 2)
      : *at == 'c' ? at[1]
      : *at == 'y' ? get(at + 2, 4)
      : *at == 'd' ? get(at + 1, 4)
                   : 0,
      at + 1);
}
static void output_differs(const char* here, const char* there, unsigned from) {
  if (*seen.output[0]) return;
  snprintf(seen.output[0], text_size, "%s", here);
  snprintf(seen.output[1], text_size, "%s", there);
  seen.from = from;
  seen.at = avr->cycle;
}

/* ---- the processor ---- */

static void keep(Moment* to) {
  memcpy(to->data, avr->data, avr->ramend + 1u);
  memcpy(to->sreg, avr->sreg, 8);
  to->pc = avr->pc, to->cycle = avr->cycle, to->interrupts = avr->interrupts;
  to->rec = rec, to->state = now, to->tick = tick;
}
static void bring_back(const Moment* from) {
  memcpy(avr->data, from->data, avr->ramend + 1u);
  memcpy(avr->sreg, from->sreg, 8);
  avr->pc = from->pc, avr->cycle = from->cycle, avr->interrupts = from->interrupts;
  rec = from->rec, now = from->state, tick = from->tick;
  avr->state = cpu_Running;
}
static unsigned top_of_heap(void) {
  const unsigned end = at_brk ? get(avr->data + at_brk, 2) : 0;
  if (highest_heap < heap_start) highest_heap = heap_start;
  if (end > highest_heap && end < avr->ramend) highest_heap = end;
  return highest_heap;
}
static void measure(void) {
  unsigned at = top_of_heap();
  while (at < avr->ramend && avr->data[at] == painted) at++;
  if (at < lowest_stack) lowest_stack = at;
}
static void check_memory(void) {
  const unsigned at = top_of_heap() + library_rest;
  if (!seen.failed && avr->ramend == 0x8FF && (at >= avr->ramend || avr->data[at] != painted)) seen.failed = 'm';
}

/* ---- calls of the program ---- */

/* What the emulator does next, once the instruction is over. */
static enum { nothing, look, mark, power_up } after_call;

static void answer_question(void) {
  take_time();
  if (now.lost || rec >= log_end || *rec == 'D' || *rec == 'W') {
    if (rec >= log_end) finished = 1;
    if (!now.lost && rec < log_end) rec++;
    put(NEXT, 0, 1);
  } else if (*rec == 'F' || *rec == 'I') {
    after_call = power_up;
    return;
  } else if (begins((char)*rec)) {
    if (*rec == 'X') {
      copy(at_message, rec + 1, 12);
      copy(at_distance, rec + 13, 4);
    }
    put(NEXT, *rec, 1);
    if (now.depth++ == 0) now.called = (char)*rec, now.outermost = 1;
    rec = after(rec);
    now.loop_begin = avr->cycle, now.waits = 0;
  } else {
    /* it has lost the log's path between two calls: should not be */
    rec = end_of_call(rec, now.depth);
    put(NEXT, 0, 1);
  }
  now.segment = rec - log_begin;
  after_call = mark;
}

static void lose(char letter, unsigned value, unsigned from) {
  char here[text_size], there[text_size];
  const uint8_t kind = avr->data[KIND];
  say(here, letter, value, &kind);
  say_record(there, rec);
  output_differs(here, there, from);
  now.lost = 1;
  now.skip = end_of_call(rec, 0);
}

static void returned(unsigned result) {
  if (now.lost)
    rec = now.skip, now.lost = 0;
  else if (*rec != 'R')
    lose('R', 0, 0), rec = now.skip, now.lost = 0;
  else {
    const int size = rec[1];
    const uint8_t* const message = avr->data + result;
    if (size == 1 && result != rec[2]) output_differs("another back-off", "this one", 0);
    if (size == 12 && (result == 0 || memcmp(message, rec + 2, 10) != 0)) {
      char here[text_size] = "no message", there[text_size];
      if (result) say(here, 'M', 0, message);
      say(there, 'M', 0, rec + 2);
      output_differs(here, there, 0);
    }
  }
  if (rec < log_end && *rec == 'R') {
    take_memory(rec + 2 + rec[1]);
    rec = after(rec);
  }
  now.depth--;
  put(NEXT, 0, 1);
  if (!now.waits && (now.called == 'L' || now.called == 'X' || now.called == 'T')) {
    const avr_cycle_count_t cycles = avr->cycle - now.loop_begin;
    if (cycles > longest) longest = cycles;
    if (cycles > tick_cycles && !seen.failed) seen.failed = 'l', seen.cycles = cycles;
  }
  compare();
  check_memory();
  after_call = look;
}

static void on_call(struct avr_t* robot_avr, avr_io_addr_t address, uint8_t letter, void* unused) {
  const unsigned value = get(avr->data + VALUE, 4), from = get(avr->data + FROM, 2) * 2;
  (void)robot_avr, (void)address, (void)unused;
  now.last_call = avr->cycle;
  if (letter != '?') now.waits_on = letter == 'i';
  put(NEXT, 0, 1);
  switch (letter) {
    case 'b':
      if (now.begun) seen.failed = 'x';
      now.begun = 1;
      put(22, 0, 4); /* no arguments of main() */
      take_values(powered + 1);
      copy(at_high, powered + 7, 28);
      copy(at_low, powered + 35, 28);
      return;
    case 'u':
      fprintf(out, "check\t%d\t%ld\t%c\t%u\n", robot, (long)(segment.rec - log_begin), avr->data[KIND], value & 0xFFFF);
      return;
    case 'i':
      if (rec < log_end && *rec == 'w') rec++, now.waits++, put(NEXT, 'w', 1);
      return;
    case '?':
      return answer_question();
    case 's':
      interrupt_vector.vector = (uint8_t)value;
  }
  if (rec >= log_end) {
    finished = 1;
    return;
  }
  if (!now.lost && *rec == 'w') {
    rec++, now.waits++;
    put(NEXT, 'w', 1);
    return;
  }
  if (letter == 'R') return returned(value);
  if (now.lost) {
    /* readings go on as they would have; nothing else happens */
    uint8_t* at = rec;
    while (at < now.skip && *at != letter) at = after(at);
    if (at < now.skip && strchr("loeh", letter)) {
      put(VALUE, get(at + 1, letter == 'h' ? 1 : 2), 4);
      rec = after(at);
    }
    return;
  }
  while (letter == 's' && rec < log_end && *rec != 's') rec = after(rec); /* what main() did counts for nothing */
  if (rec >= log_end || *rec != letter) return lose(letter, value, from);
  if (strchr("loeh", letter)) {
    put(VALUE, get(rec + 1, letter == 'h' ? 1 : 2), 4);
  } else if (letter == 'd') {
    const double other = get(rec + 1, 4);
    if (fabs(value - other) > 1 + other / 1000) {
      char here[text_size], there[text_size];
      say(here, 'd', value, 0), say_record(there, rec);
      output_differs(here, there, from);
    }
    take_memory(rec + 5);
    now.waits++;
    compare();
    after_call = look;
  } else if (letter == 's') {
    take_memory(rec + 1);
    compare();
    after_call = look;
  } else if ((letter == 'm' && value != get(rec + 1, 2)) || (letter == 'c' && value != rec[1]) ||
             (letter == 'y' && (value != get(rec + 2, 4) || avr->data[KIND] != rec[1]))) {
    char here[text_size], there[text_size];
    say(here, (char)letter, value, avr->data + KIND), say_record(there, rec);
    output_differs(here, there, from);
  }
  rec = after(rec);
}

/* ---- running ---- */

static void step(void) {
  const int state = avr_run(avr);
  if (state == cpu_Done || state == cpu_Crashed || (avr->pc == 0 && now.begun)) seen.failed = 'x';
  if (avr->cycle - now.last_call > (now.waits_on ? wait_cycles : quiet_cycles) && rec < log_end) {
    if (*rec == 'w' && !now.lost && avr->sreg[S_I]) {
      avr_raise_interrupt(avr, &interrupt_vector);
      now.last_call = avr->cycle;
    } else if (avr->cycle - now.last_call > hung_cycles) {
      seen.failed = 'h';
    }
  }
}

/* Repeats the segment and finds out which instruction last wrote each number that differs: the earliest one is the
   cause. Returns that number's place in seen.leaf. */
static int first_written(unsigned* from, avr_cycle_count_t* when) {
  static Moment end;
  static uint8_t old[most_leaves][8];
  static unsigned wrote[most_leaves];
  static avr_cycle_count_t at[most_leaves];
  const typeof(seen) found = seen;
  const int was_finished = finished;
  uint8_t bytes[1024];
  avr_eeprom_desc_t eeprom = {bytes, 0, sizeof bytes};
  int i, best = 0;
  avr_ioctl(avr, AVR_IOCTL_EEPROM_GET, &eeprom);
  keep(&end);
  bring_back(&segment);
  compares = 0;
  for (i = 0; i < found.count; i++) {
    memcpy(old[i], avr->data + leaves[found.leaf[i]].here, leaves[found.leaf[i]].here_size);
    wrote[i] = 0, at[i] = 0;
  }
  for (after_call = nothing; after_call != look && avr->cycle < end.cycle + 1000;) {
    const unsigned pc = avr->pc;
    step();
    for (i = 0; i < found.count; i++) {
      const Leaf* leaf = leaves + found.leaf[i];
      if (memcmp(old[i], avr->data + leaf->here, leaf->here_size) == 0) continue;
      memcpy(old[i], avr->data + leaf->here, leaf->here_size);
      wrote[i] = pc, at[i] = avr->cycle;
    }
  }
  for (i = 1; i < found.count; i++)
    if (at[i] && (!at[best] || at[i] < at[best])) best = i;
  *from = wrote[best], *when = at[best];
  bring_back(&end);
  avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &eeprom);
  seen = found;
  finished = was_finished;
  compares = 1;
  return best;
}

static void run(void);

/* Where this difference shows first: a copy of this process goes on with it. */
static void foresee(char* text) {
  int ends[2], size;
  pid_t copy_of_us;
  *text = 0;
  fflush(out);
  if (pipe(ends) != 0) return;
  copy_of_us = fork();
  if (copy_of_us == 0) {
    close(ends[0]);
    child = ends[1];
    memset(&seen, 0, sizeof seen);
    run();
    _exit(0);
  }
  close(ends[1]);
  size = (int)read(ends[0], text, 4 * text_size - 1);
  text[size > 0 ? size : 0] = 0;
  close(ends[0]);
  waitpid(copy_of_us, 0, 0);
}

/* Tells what differs in the segment that has just ended, and makes the robot what it should be. */
static void tell(void) {
  char shown[4 * text_size] = "", here[32] = "", there[32] = "";
  unsigned from = seen.from;
  int i, leaf = -1;
  char kind = (char)seen.failed;
  after_call = nothing;
  if (!seen.count && !*seen.output[0] && !seen.failed) return;
  if (child >= 0) {
    if (*seen.output[0] || seen.failed == 'x' || seen.failed == 'h') {
      const int size = snprintf(shown, sizeof shown, "%u\t%s\t%s", tick, *seen.output[0] ? seen.output[0] : "a crash",
                                seen.output[1]);
      _exit(write(child, shown, (size_t)size) != size);
    }
    memset(&seen, 0, sizeof seen);
    return;
  }
  if (kind == 'm' || kind == 'l') seen.failed = 0;
  if (!kind && seen.count) {
    avr_cycle_count_t when;
    unsigned wrote = 0;
    const int first = now.segment < 0 ? (when = 0, 0) : first_written(&wrote, &when); /* < 0: in main() */
    if (!*seen.output[0] || (when && when < seen.at)) {
      const char* const form = leaves[seen.leaf[first]].type == 'f' ? "%.9g" : "%.0f";
      kind = 'v', leaf = seen.leaf[first], from = wrote;
      snprintf(here, sizeof here, form,
               number(avr->data + leaves[leaf].here, (int)leaves[leaf].here_size, leaves[leaf].type));
      snprintf(there, sizeof there, form,
               number(image + leaves[leaf].there, (int)leaves[leaf].there_size, leaves[leaf].type));
    }
  }
  if (!kind) kind = 'o';
  if (strchr("xhm", kind)) from = (unsigned)avr->pc;
  for (i = 0; i < cause_count; i++)
    if (causes[i].kind == kind &&
        (kind == 'l' || kind == 'm' || (causes[i].from == from && (from || causes[i].leaf == leaf))))
      break;
  if (i < most_causes) {
    if (i == cause_count) {
      causes[cause_count++] = (Cause){kind, from, leaf, 0};
      if (kind == 'v' && *seen.output[0])
        snprintf(shown, sizeof shown, "%u\t%s\t%s", tick, seen.output[0], seen.output[1]);
      else if (kind == 'v')
        foresee(shown);
      if (kind == 'o') snprintf(shown, sizeof shown, "%u\t%s\t%s", tick, seen.output[0], seen.output[1]);
      fprintf(out, "cause\t%d\t%c\t%d\t%ld\t%u\t%u\t%d\t%d\t%s\t%s\t%llu\t%c\t%s\n", i, kind, robot,
              (long)(segment.rec - log_begin), tick, from, leaf, seen.count, here, there,
              (unsigned long long)seen.cycles, now.called ? now.called : '-', shown);
    }
    causes[i].count++;
  }
  if ((kind == 'm' || kind == 'l') && (seen.count || *seen.output[0])) return tell();
  for (i = 0; i < leaf_count; i++) become(leaves + i);
  if ((kind == 'x' || kind == 'h') && now.segment < 0) {
    finished = 1; /* in main() */
  } else if (kind == 'x' || kind == 'h') {
    bring_back(&top);
    now.depth = 0;
    rec = end_of_call(rec, 0);
    if (rec < log_end && *rec == 'R') take_memory(rec + 2 + rec[1]), rec = after(rec);
    for (i = 0; i < leaf_count; i++) become(leaves + i);
    answer_question();
  }
  memset(&seen, 0, sizeof seen);
}

static void start(void) {
  avr_eeprom_desc_t eeprom;
  uint8_t bytes[1024];
  int i;
  while (rec < log_end && *rec != 'I') rec = after(rec);
  if (rec >= log_end) {
    finished = 1;
    return;
  }
  memset(&now, 0, sizeof now);
  now.segment = -1;
  avr_reset(avr);
  avr->data[INTERRUPTS] = 1;
  avr->data[R_SPL] = avr->ramend & 255, avr->data[R_SPH] = avr->ramend >> 8;
  memset(avr->data + 0x100, painted, avr->ramend + 1u - 0x100);
  for (i = 0; i < 1024; i++) bytes[i] = (uint8_t)~rec[1 + 6 + 56 + i];
  eeprom.ee = bytes, eeprom.offset = 0, eeprom.size = 1024;
  avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &eeprom);
  powered = rec;
  rec = after(rec);
  now.last_call = avr->cycle;
  highest_heap = 0;
}

/* simavr itself, at an address that no robot has. */
static sigjmp_buf wild;
static void caught(int signal) {
  (void)signal;
  siglongjmp(wild, 1);
}

static void run(void) {
  const avr_cycle_count_t begin = avr->cycle;
  if (sigsetjmp(wild, 1)) seen.failed = 'x', tell();
  while (!finished && avr->cycle - begin < budget) {
    step();
    if (seen.failed == 'x' || seen.failed == 'h') tell();
    if (after_call == look) tell();
    if (after_call == mark) {
      after_call = nothing;
      if (now.outermost) now.outermost = 0, keep(&top);
      keep(&segment);
    }
    if (after_call == power_up) {
      measure();
      after_call = nothing;
      start();
    }
  }
  measure();
}

static uint8_t* read_file(const char* name, long* size) {
  FILE* const file = fopen(name, "rb");
  uint8_t* bytes;
  if (!file || fseek(file, 0, SEEK_END) != 0) give_up("cannot read", name);
  *size = ftell(file);
  rewind(file);
  bytes = malloc((size_t)*size + 16);
  if (!bytes || fread(bytes, 1, (size_t)*size, file) != (size_t)*size) give_up("cannot read", name);
  memset(bytes + *size, 0, 16);
  fclose(file);
  return bytes;
}

static void quiet(avr_t* of, const int level, const char* format, va_list values) {
  (void)of, (void)level, (void)format, (void)values;
}

static void read_table(const char* name) {
  static const char* const known[] = {"ticks",          "uid",  "turn_left", "turn_right", "straight_left",
                                      "straight_right", "high", "low",       "message",    "distance"};
  unsigned* const places[] = {&at_ticks,     &at_uid,  at_duties, at_duties + 1, at_duties + 2,
                              at_duties + 3, &at_high, &at_low,   &at_message,   &at_distance};
  FILE* const file = fopen(name, "r");
  char line[200], word[40];
  unsigned place;
  size_t i;
  if (!file) give_up("cannot read", name);
  while (fgets(line, sizeof line, file)) {
    Leaf* const leaf = leaves + leaf_count;
    if (sscanf(line, "%u %u %u %u %c", &leaf->here, &leaf->here_size, &leaf->there, &leaf->there_size, &leaf->type) ==
        5) {
      if (leaf_count < most_leaves - 1) leaf_count++;
    } else if (sscanf(line, "%39s %u", word, &place) == 2) {
      for (i = 0; i < sizeof places / sizeof *places; i++)
        if (strcmp(word, known[i]) == 0) *places[i] = place;
    }
  }
  fclose(file);
}

int main(int count, char** words) {
  avr_cycle_count_t left, spent;
  uint8_t* program;
  long program_size, size;
  int i;
  if (count < 9) return 2;
  out = fopen(words[1], "w");
  if (!out) give_up("cannot write", words[1]);
  avr_global_logger_set(quiet);
  signal(SIGSEGV, caught);
  program = read_file(words[3], &program_size);
  heap_start = (unsigned)strtoul(words[4], 0, 0) & 0xFFFF;
  at_brk = (unsigned)strtoul(words[5], 0, 0) & 0xFFFF;
  read_table(words[6]);
  left = strtoull(words[7], 0, 0);
  for (i = 8; i < count; i++) {
    robot = atoi(strrchr(words[i], '/') + 1);
    avr = avr_make_mcu_by_name(words[2]);
    if (!avr) give_up("simavr does not know", words[2]);
    avr_init(avr);
    avr->frequency = 8000000;
    avr_loadcode(avr, program, (uint32_t)program_size, 0);
    avr->codeend = avr->flashend;
    avr_register_io_write(avr, CALL, on_call, 0);
    interrupt_vector.enable = (avr_regbit_t)AVR_IO_REGBIT(INTERRUPTS, 0);
    interrupt_vector.vector = 25;
    avr_register_vector(avr, &interrupt_vector);
    rec = log_begin = read_file(words[i], &size);
    log_end = log_begin + size;
    memset(image, 0, sizeof image);
    memset(&seen, 0, sizeof seen);
    compares = 1, finished = 0, longest = 0, lowest_stack = avr->ramend + 1u;
    after_call = nothing;
    budget = left / (unsigned)(count - i);
    start();
    spent = avr->cycle;
    run();
    spent = avr->cycle - spent;
    left = left > spent ? left - spent : 0;
    fprintf(out, "robot\t%d\t%u\t%u\t%llu\t%u\n", robot, highest_heap > heap_start ? highest_heap - heap_start : 0,
            avr->ramend + 1u - lowest_stack, (unsigned long long)longest, finished ? 0 : tick);
    free(log_begin);
  }
  for (i = 0; i < cause_count; i++) fprintf(out, "count\t%d\t%ld\n", i, causes[i].count);
  return fclose(out) != 0;
}
