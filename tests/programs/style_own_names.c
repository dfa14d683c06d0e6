/* Style: defines for itself all the short names that a library must leave free. Green when they mean what it says. */
#include "kilolib.h"

#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define PI 3.14
#define STOP 0
#define FORWARD 1
#define LEFT 2
#define RIGHT 3
#define ON 1
#define OFF 0
#define TICKS 32
#define abs_diff(a, b) ((a) > (b) ? (a) - (b) : (b) - (a))
typedef unsigned char bool;
typedef unsigned char byte;
enum { false, true };
enum color { RED, GREEN, BLUE, WHITE, BLACK };
typedef struct { int x, y; } position_t;
typedef struct { int mode; } robot;
struct host { int text; };

int motion = STOP;
int direction, state, distance, ticks, light, host = 5, rx, tx, worker, arena, self, uid;
robot me;
position_t position;
bool started = false;

int clamp(int v, int lo, int hi) { return max(lo, min(v, hi)); }
void wait(int n) { delay(n); }
int round_up(int x) { return x + 1; }
void motors(int left, int right) { set_motors(left, right); }
void colour(int c) { set_color(c); }

void setup() {
    started = true;
    host += clamp(500, 0, 10);
    motors(0, 0);
    wait(10);
}

void loop() {
    int good = started == true && host == 15 && min(LEFT, RIGHT) == LEFT && (int)(100 * PI) == 314 && abs_diff(3, 5) == 2 && WHITE == 3;
    colour(good ? RGB(0, 3, 0) : RGB(3, 0, 0));
    wait(100);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
