/* Style: one huge switch over a step counter with fall-through, goto for the way out, static locals, recursion, a big constant table. */
#include <kilolib.h>
static const uint16_t table[256] = { [0] = 1, [17] = 5, [255] = 9 };
static int fib(int n) { return n < 2 ? n : fib(n - 1) + fib(n - 2); }
static uint32_t due;
void setup() { due = kilo_ticks; }
void loop() {
    static int step = 0;
    static uint8_t bad;
    if (kilo_ticks < due) return;
    switch (step++) {
    case 0: due += 5; break;
    case 1: due += 5; if (fib(12) != 144) goto fail; break;
    case 2: if (table[17] + table[255] != 14) goto fail; /* falls through */
    case 3: due += 5; break;
    case 4: { int x = 3; while (x) { if (--x == 1) continue; } due += 2; } break;
    case 5: case 6: case 7: case 8: due += step; break;
    case 9: for (;;) { if (++due % 7 == 0) break; } break;
    default: if (bad) goto fail; set_color(RGB(0, 3, 0)); step = 0; due += 31; break;
    }
    return;
fail:
    bad = 1;
    set_color(RGB(3, 0, 0));
}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
