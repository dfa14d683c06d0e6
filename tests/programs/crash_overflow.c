/* Writes 100 kB past the end of an array. */
#include <kilolib.h>

char table[16];
volatile long n = 100000;

void setup() {}
void loop() {
    long i;
    if (kilo_ticks > 31 && kilo_uid == 4)
        for (i = 0; i < n; i++) table[i] = 1;
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
