/* The processor, and the calls of the program. A part of emulator.c. */
#pragma once

#include "log.h"

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
  if (now.amid > now.depth + 1) now.amid = 0;
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
      if (rec < log_end && *rec == 'w') begin_wait();
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
    begin_wait();
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
  for (; letter == 's' && rec < log_end && *rec != 's'; rec = after(rec)) /* what main() did counts for nothing */
    if (*rec == 'w' || *rec == 'd') take_memory(rec + (*rec == 'w' ? 2 : 5));
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
    if (now.amid > now.depth) now.amid = 0;
    compare();
    after_call = look;
  } else if (letter == 's') {
    take_memory(rec + 1);
    now.amid = 0;
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
