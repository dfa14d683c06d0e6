/* What the rows of tests/sim_ode/host/firmware_table.txt run: does what it is told, and counts. Runs on a real robot,
 * too. */
#include <kilolib.h>

volatile uint8_t table_setups, table_asked;

static volatile uint8_t job[4]; /* waits for so many tenths of a second, then colour and duties; wait 0: nothing */
static volatile uint8_t setup_tenths;
static message_t said;

static void hear(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type == 1) set_color(message->data[0]);
  if (message->type == 2) set_motors(message->data[0], message->data[1]);
  if (message->type == 3)
    for (i = 0; i < 4; i++) job[i] = message->data[i];
  if (message->type == 4) setup_tenths = message->data[0];
}

static message_t* speak() {
  table_asked++;
  said.data[0] = table_setups;
  said.crc = message_crc(&said);
  return &said;
}

static void wait_tenths(uint8_t tenths) {
  while (tenths--) delay(100);
}

static void setup() {
  table_setups++;
  set_color(RGB(1, 0, 0));
  set_motors(70, 0);
  wait_tenths(setup_tenths);
}

static void loop() {
  if (job[0] == 0) return;
  wait_tenths(job[0]);
  job[0] = 0;
  set_color(job[1]);
  set_motors(job[2], job[3]);
}

int main() {
  kilo_init();
  kilo_message_rx = hear;
  kilo_message_tx = speak;
  kilo_start(setup, loop);
  return 0;
}
