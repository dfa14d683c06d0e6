/* Stands, and shows a colour by chance for a third of a second, or none, over and over. */
#include <arkmesh_id.h>
#include <kilolib.h>

static uint32_t next;

void setup() {}
void loop() {
  if (kilo_ticks < next) return;
  next = kilo_ticks + 10;
  set_color(RGB(rand_hard() & 3, rand_hard() & 3, rand_hard() & 3));
}

int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
