/* Blocks that are never given back, until there is no room: green while there is, blue then; red when there is room for
   60000 bytes, or what a robot wrote is not there. */
#include "kilolib.h"
#include <stdlib.h>
#include <string.h>

typedef struct block {
  struct block* before;
  uint8_t id;
} block_t;

static block_t* last;
static uint16_t count;

static void setup(void) {
  set_color(malloc(60000) ? RGB(1, 0, 0) : RGB(0, 1, 0));
}
static void loop(void) {
  block_t* next = calloc(1, kilo_uid % 2 ? 100 : 200);
  uint16_t found = 0;
  if (next) {
    next->before = last;
    next->id = (uint8_t)(kilo_uid + 1);
    last = next;
    count++;
  }
  for (block_t* at = last; at; at = at->before) found += at->id == kilo_uid + 1;
  if (found != count)
    set_color(RGB(1, 0, 0));
  else if (!next)
    set_color(count * (kilo_uid % 2 ? 100 : 200) > 6000 ? RGB(0, 0, 1) : RGB(1, 1, 1));
}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
