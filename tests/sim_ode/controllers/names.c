/* Names that other headers like to take, and those of the C library, belong to the program. Old-style callbacks. */
#include "kilolib.h"

enum { STOP, LEFT, RIGHT, STRAIGHT };
#define PI 3.14159
typedef unsigned char bool;
static const bool true = 1, false = 0;
int min, max;
int send, sync, time, clock, signal, link, pipe;
int read() { return send + sync + time; }
void write() { min = max = clock + signal + link + pipe; }
int index(int a) { return a; }
message_t unused, both; /* tentative definitions */
message_t both;

void my_rx() { write(); }
message_t *my_tx() { return 0; }
void my_setup() { min = 5; }
void my_loop() {
  if (read() == 0 && index(3) == 3 && true && !false && min == 5) set_color(RGB(0, 1, 0));
}
int main(void) {
  kilo_message_rx = my_rx;
  kilo_message_tx = my_tx;
  kilo_init();
  kilo_start(my_setup, my_loop);
  while (1);
}
