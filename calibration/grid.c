/* Infrared among robots that all speak: for 150 s each robot says its number as often as it can, but asks for
   no message until more than TAU ticks after it asked for the last one. Then it prints how many it sent, and how many
   it heard of each other robot. */
#define DEBUG
#include <debug.h>
#include <kilolib.h>

#define ROBOTS 25
#define LAST (150 * 32) /* ticks */

static message_t mine;
static uint16_t heard[ROBOTS];
static uint32_t began, asked;
static uint8_t waiting, told;

static message_t* tx() {
  return waiting ? &mine : 0;
}
static void sent() {
  ++heard[kilo_uid % ROBOTS];
  waiting = 0;
}
static void rx(message_t* m, distance_measurement_t* d) {
  (void)d;
  if (!told) ++heard[m->data[0]];
}

void setup() {
  rand_seed(rand_hard());
  delay(rand_soft());
  mine.data[0] = kilo_uid % ROBOTS;
  mine.crc = message_crc(&mine);
  began = kilo_ticks;
  asked = began + rand_soft() % (TAU + 1);
}
void loop() {
  if (kilo_ticks - began > LAST) {
    waiting = 0;
    if (!told)
      for (uint8_t i = 0; i < ROBOTS; ++i) printf("%u ", heard[i]);
    if (!told) printf("\n");
    told = 1;
  } else if (!waiting && (int32_t)(kilo_ticks - asked) > TAU) {
    asked = kilo_ticks;
    waiting = 1;
  }
}
int main() {
  kilo_init();
  debug_init();
  kilo_message_tx = tx;
  kilo_message_tx_success = sent;
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
