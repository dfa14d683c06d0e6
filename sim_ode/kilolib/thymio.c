/* What a simulated Thymio runs unless its lab's file names another program: it shows the colour that it was last told,
   as the kind of a word (1 red, 2 green, 4 blue, and their sums; 0 dark), and leaves its wheels to set points. */
#include <kilolib.h>

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

static void loop(void) {}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
