/* Style: a field of its own is called kilo_ticks, like the clock. Green after ten ticks. */
#include <kilolib.h>
struct { uint32_t kilo_ticks; int kilo_uid; } my;
void setup() { my.kilo_ticks = kilo_ticks; }
void loop() { if (kilo_ticks > my.kilo_ticks + 10) set_color(RGB(0,3,0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
