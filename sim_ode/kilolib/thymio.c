/* What a simulated Thymio runs unless its lab's file names another program, as robot.aesl does on a real one: it shows
   the colour that it was last told, as the kind of a word (1 red, 2 green, 4 blue, and their sums; 0 dark), leaves its
   wheels to set points, and says what its proximity sensors read: each 0.1 s the reading that has changed most. */
#include <arkmesh_say.h>
#include <kilolib.h>
#include <thymio.h>

enum { sensors = 7, said_each = 3 /* ticks */, least_change = 200 };
static int16_t said[sensors];
static uint32_t looked_at;

static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    const uint8_t colour = block[1] >> 2 & 7;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) == kilo_uid)
      set_color(RGB(colour & 1 ? 3 : 0, colour & 2 ? 3 : 0, colour & 4 ? 3 : 0));
  }
}

static void setup(void) {}

static void loop(void) {
  uint8_t i, which = 0;
  int16_t most = 0, value = 0;
  if (kilo_ticks - looked_at < said_each) return;
  looked_at = kilo_ticks;
  for (i = 0; i < sensors; i++) {
    const int16_t reading = thymio_prox(i);
    const int16_t change = reading > said[i] ? reading - said[i] : said[i] - reading;
    if (change > most) most = change, which = i, value = reading;
  }
  if (most <= least_change) return;
  said[which] = value;
  arkmesh_say(which, value);
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
