/* Checks the library against a robot's values; shows green when all hold. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kilolib.h"

static uint16_t crc_of(const char *bytes) {
  message_t m;
  memset(&m, 0, sizeof m);
  memcpy(m.data, bytes, 9);
  m.type = bytes[9];
  return message_crc(&m);
}

static uint8_t mm(int high, int low) {
  distance_measurement_t d;
  d.high_gain = high;
  d.low_gain = low;
  return estimate_distance(&d);
}

void setup() {
  static const uint8_t soft[] = {253, 21, 184, 123, 167, 154, 73, 0, 2, 16, 150, 37, 14, 126, 137, 196};
  static const int random[] = {16807, 15089, 11481, 3114, 14210};
  uint8_t i;
  char text[] = "a b";

  assert(sizeof(message_t) == 12 && sizeof(distance_measurement_t) == 4);
  assert(RGB(1, 2, 3) == (1 | 2 << 2 | 3 << 4));
  assert(TICKS_PER_SEC == 31 && kilo_tx_period == 3906 && RAND_MAX == 32767);
  assert(kilo_uid == 0);
  assert((char)200 == 200); /* char is unsigned */

  assert(crc_of("\1\2\3\4\5\6\7\10\11\0") == 0xA718);
  assert(crc_of("\0\0\0\0\0\0\0\0\0\0") == 0x9C87);
  assert(crc_of("\0\0\0\0\0\0\0\0\0\1") == 0x8D0E);
  assert(crc_of("\377\377\377\377\377\377\377\377\377\177") == 0x036D);
  assert(crc_of("\0\0\0\0\0\0\0\0\0\x80") == 0x188F);
  assert(crc_of("\0\0\0\0\0\0\0\0\0\x83") == 0x2A14);
  assert(crc_of("\0\0\0\0\0\0\0\0\0\x88") == 0x94C7);
  assert(crc_of("\0\x11\x22\x33\x44\x55\x66\x77\x88\0") == 0x30B1);

  for (i = 0; i < 16; i++) assert(rand_soft() == soft[i]);
  for (i = 0; i < 5; i++) assert(rand() == random[i]);
  srand(1);
  assert(rand() == random[0]);

  assert(mm(950, 700) == 36 && mm(950, 500) == 43 && mm(800, 330) == 50 && mm(720, 300) == 53);
  assert(mm(600, 100) == 61 && mm(300, 50) == 93 && mm(270, 50) == 98 && mm(200, 50) == 109);
  assert(mm(1023, 1023) == 33 && mm(1023, 50) == 123);

  assert(!strcmp(strtok(text, " "), "a") && !strcmp(strtok(NULL, " "), "b"));
  assert(sqrt(2.0) > 1.41);
  set_color(RGB(0, 1, 0));
}

void loop() {}

int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
