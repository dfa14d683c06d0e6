/* Style: inline functions without static, large enough not to be inlined, called from several places, one by its address. Green. */
#include <kilolib.h>
inline int mix(int a, int b) {
    int i, s = 0;
    for (i = 0; i < 20; i++) { s = s * 31 + a; if (s & 1) s ^= b; else s += i; switch (s & 7) { case 1: s += 3; break; case 2: s -= a; break; case 5: s ^= 77; break; } }
    return s;
}
inline void show(uint8_t c) { set_color(c); }
extern inline int twice(int x) { return 2 * x; }
static inline __attribute__((always_inline)) int thrice(int x) { return 3 * x; }
int (*by_address)(int, int) = mix;
int a, b;
void setup() { a = mix(1, 2); b = mix(3, 4); }
void loop() { show(a == by_address(1, 2) && b == mix(3, 4) && mix(5, 6) == mix(5, 6) && thrice(2) == 6 && twice(2) == 4 ? RGB(0, 3, 0) : RGB(3, 0, 0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
