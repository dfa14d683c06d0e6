/* Style: what GNU C allows beyond the standard: nested functions, statement expressions, ranges of cases, typeof, empty structures, zero
   and variable length arrays, labels as values, binary numbers, ?: without a middle, designated ranges. Green when all agree. */
#include <kilolib.h>
#define MAX(a, b) ({ typeof(a) _a = (a); typeof(b) _b = (b); _a > _b ? _a : _b; })
static const uint8_t levels[10] = { [0 ... 4] = 1, [5 ... 9] = 2 };
struct nothing { };
struct tail { uint8_t n; uint8_t data[0]; };
static int good;
int kind(int c) { switch (c) { case '0' ... '9': return 1; case 'a' ... 'z': return 2; default: return 3; } }
int walk(int n) {
    static void *places[] = { &&first, &&second, &&last };
    int steps = 0;
    goto *places[n];
first: steps += 1;
second: steps += 10;
last: return steps + 100;
}
void setup() {
    int total = 0;
    void add(int x) { total += x; }
    for (int i = 1; i <= 4; i++) add(i);
    uint8_t room[total];
    for (int i = 0; i < total; i++) room[i] = i;
    int zero = 0;
    good = total == 10 && room[9] == 9 && MAX(3, total) == 10 && kind('5') == 1 && kind('q') == 2 && walk(0) == 111 && walk(2) == 100 && 0b1010 == 10 &&
           (zero ?: 7) == 7 && levels[4] == 1 && levels[5] == 2 && sizeof(struct nothing) == 0 && sizeof(struct tail) == 1;
}
void loop() { set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
