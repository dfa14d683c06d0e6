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
   d microseconds memory ... D  delay and its end, with what came between
   w busy memory ... W  a wait without a call; busy: 1 amid what the program does, 0 where it reads the clock
   F                           the program is forgotten, until power-up

   OUT gets: `cause`, a tick's difference, once for each place; `check` of the compiler's own checks; `robot` figures.
 */
#include "calls.h"

/* Whether the processor reads the clock, byte by byte: between two of them time goes on neither here nor there. */
static int reads_clock(void) {
  const uint8_t* const next = avr->flash + avr->pc;
  if (!at_ticks || avr->pc + 4 > avr->flashend || ((next[0] | next[1] << 8) & 0xFE0F) != 0x9000) return 0; /* no LDS */
  const unsigned address = next[2] | next[3] << 8;
  return address >= at_ticks && address < at_ticks + 4;
}

static void step(void) {
  const int state = avr_run(avr);
  if (state == cpu_Done || state == cpu_Crashed || (avr->pc == 0 && now.begun)) seen.failed = 'x';
  if (avr->cycle - now.last_call > (now.waits_on ? wait_cycles : quiet_cycles) && rec < log_end) {
    if (*rec == 'w' && !now.lost && avr->sreg[S_I]) {
      if (reads_clock()) return;
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
  all_become();
  if ((kind == 'x' || kind == 'h') && now.segment < 0) {
    finished = 1; /* in main() */
  } else if (kind == 'x' || kind == 'h') {
    bring_back(&top);
    now.depth = 0;
    rec = end_of_call(rec, 0);
    if (rec < log_end && *rec == 'R') take_memory(rec + 2 + rec[1]), rec = after(rec);
    all_become();
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
