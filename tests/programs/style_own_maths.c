/* Style: own versions of functions that a C compiler knows by heart, with other meanings or types. Green when its own are called. */
#include <kilolib.h>
int round(int x) { return (x + 5) / 10 * 10; }
int pow(int base, int n) { int r = 1; while (n-- > 0) r *= base; return r; }
uint8_t sqrt(uint16_t x) { uint8_t r = 0; while ((uint16_t)(r + 1) * (r + 1) <= x) r++; return r; }
int abs(int x) { return x < 0 ? -x : x; }
uint8_t max(uint8_t a, uint8_t b) { return a > b ? a : b; }
uint8_t min(uint8_t a, uint8_t b) { return a < b ? a : b; }
void log(uint8_t what) { set_color(what); }
void memory_copy(uint8_t *to, const uint8_t *from, uint8_t n) { while (n--) *to++ = *from++; }
int floor(int x) { return x & ~7; }

long random(long a) { return a * 7; }
char *strcpy_own(char *a, const char *b) { char *r = a; while ((*a++ = *b++)) ; return r; }
void swap(int *a, int *b) { int t = *a; *a = *b; *b = t; }
int exp(int x) { return x + 1; }
int y = 4;
void error() { set_color(RGB(3, 0, 0)); }
void signal(int n) { y = n; }
void setup() { signal(5); }
void loop() {
    int a = 1, b = 2;
    swap(&a, &b);
    if (round(17) == 20 && pow(3, 4) == 81 && sqrt(50) == 7 && abs(-4) == 4 && max(1, 2) == 2 && min(1, 2) == 1 && floor(15) == 8 &&
        random(3) == 21 && exp(1) == 2 && a == 2 && b == 1 && y == 5) log(RGB(0, 3, 0));
    else error();
}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
