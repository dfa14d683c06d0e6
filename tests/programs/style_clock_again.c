/* Style: declares the clock once more, assigns and counts it up, takes its address, waits for it in main(), which returns nothing. Green. */
#include <kilolib.h>
extern volatile uint32_t kilo_ticks;
extern uint16_t kilo_uid;
struct { uint32_t last; } s;
uint32_t *p;
void setup() { kilo_ticks = 5; kilo_ticks++; s.last = kilo_ticks + sizeof(kilo_ticks); }
int loop() { volatile uint32_t *t = &kilo_ticks; if (*t >= s.last) set_color(RGB(0,3,0)); return 3; }
void main(void) { kilo_init(); kilo_init(); while (kilo_ticks < 20); delay(100); kilo_start(setup, loop); }
