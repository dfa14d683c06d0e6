/* Reach among robots that walk: robot 0 stands and asks to speak each PACE ticks; the others walk at random, and shine
   from the first word on that they hear and think not farther away than CUT mm. */
#include <kilolib.h>

static message_t word;
static uint32_t until, said;
static uint8_t speaks, walks;

static message_t* tx() {
  return speaks ? &word : 0;
}
static void sent() {
  speaks = 0;
}
static void rx(message_t* m, distance_measurement_t* d) {
  (void)m;
  if (kilo_uid && estimate_distance(d) <= CUT) set_color(RGB(3, 0, 3));
}

void setup() {
  rand_seed(rand_hard());
  word.crc = message_crc(&word);
  until = kilo_ticks;
}
void loop() {
  if (!kilo_uid) {
    if (!speaks && kilo_ticks > said + PACE) {
      said = kilo_ticks;
      speaks = 1;
    }
  } else if (kilo_ticks > until) {
    /* straight on for 3 s, then a turn to either side that is more often small than large; each in the mean */
    const uint16_t chance = rand_soft();
    walks = !walks;
    until = kilo_ticks + (walks ? chance * 3 / 4 : (uint32_t)chance * chance / 1024);
    spinup_motors();
    if (walks)
      set_motors(kilo_straight_left, kilo_straight_right);
    else if (rand_soft() & 1)
      set_motors(kilo_turn_left, 0);
    else
      set_motors(0, kilo_turn_right);
  }
}
int main() {
  kilo_init();
  kilo_message_tx = tx;
  kilo_message_tx_success = sent;
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
