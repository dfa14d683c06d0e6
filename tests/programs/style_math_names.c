/* Style: variables and functions with names that a PC's mathematics and string headers take and a robot's do not. Green when they are
   its own. */
#include <kilolib.h>
#include <math.h>
#include <string.h>
#include <stdlib.h>
#include <stdio.h>
#include <stdint.h>

uint8_t y0 = 1, y1 = 2, j0 = 3, j1 = 4, yn = 5, jn = 6, gamma = 7;
int index = 8, rindex = 9;
typedef uint8_t uint;
typedef uint8_t ushort;
typedef struct { int x; } id_t;
typedef int8_t key_t;
int getline(int n) { return n + 10; }
int dprintf = 12;
int select(int a) { return a * 2; }
int remainder_of = 3;
uint8_t step(uint8_t v) { return v + 1; }
int basename = 14, strdup_count = 2;
static id_t id;
double drem(double a) { return a / 2; }
int significand = 4;
int putw = 1, getw = 2, mktemp = 4, setenv = 5, random_count = 6;

void setup() { id.x = 3; }
void loop() {
    uint a = 255; a++;
    int good = y0 + y1 + j0 + j1 + yn + jn + gamma == 28 && index == 8 && rindex == 9 && getline(1) == 11 && select(4) == 8 && a == 0 &&
               id.x == 3 && drem(4) == 2 && fabs(M_PI - 3.14159) < 0.001 && strlen("abc") == 3 && abs(-3) == 3 && basename == 14 && step(1) == 2;
    set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0));
}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
