/* Style: own macros for printing that vanish without DEBUG, printf with debug.h but without DEBUG, an assert of its own. Green. */
#include <kilolib.h>
#include <debug.h>
#ifdef DEBUG
#define dbg(...) printf(__VA_ARGS__)
#else
#define dbg(...)
#endif
#define assert(x) do { if (!(x)) { set_color(RGB(3,0,0)); delay(1000); } } while (0)
#define PI 3.14159265
#define true 1
#define false 0
typedef uint8_t bool;
bool ok = true;
void setup() { debug_init(); dbg("hello %d", 3); printf("unseen %d\n", kilo_uid); }
void loop() { assert(ok == true); assert(PI > 3); set_color(RGB(0,3,0)); }
int main() { kilo_init(); debug_init(); kilo_start(setup, loop); return 0; }
