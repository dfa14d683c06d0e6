/* The records of a log, numbers in memory, and what a program says, in words. A part of emulator.c. */
#pragma once

#include "state.h"

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
    case 'w':
      return after_memory(at + 2);
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
    if (*at == 'w') take_memory(at + 2);
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
    if (!(now.amid && amid[i]) && differs(leaves + i)) seen.leaf[seen.count++] = i;
}
static void all_become(void) {
  int i;
  for (i = 0; i < leaf_count; i++)
    if (!(now.amid && amid[i])) become(leaves + i);
}
/* Where the robot stands may be elsewhere than where the simulated one does, within one stretch without a call: what
   differs is not looked at until the call is over in which it waits. */
static void begin_wait(void) {
  int i;
  take_memory(rec + 2);
  if (rec[1] && compares && child < 0 && (!now.amid || now.amid == now.depth + 1)) {
    now.amid = now.depth + 1;
    for (i = 0; i < leaf_count; i++) amid[i] = (uint8_t)differs(leaves + i);
  }
  rec = after(rec), now.waits++;
  put(NEXT, 'w', 1);
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
