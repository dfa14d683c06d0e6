/* Style: makes text with the robot's C library: itoa, utoa, ltoa, dtostrf, sprintf, strtol, strlcpy, strrev. Green when right. */
#include <kilolib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
static uint8_t good = 0;
void setup() {
    char a[16], b[16], c[16], d[16], e[16], f[6];
    itoa(-42, a, 10);
    utoa(255, b, 16);
    ltoa(100000L, c, 10);
    dtostrf(3.14159, 6, 2, d);
    sprintf(e, "%03d|%c|%x", 7, 'z', 0xBEEF);
    good = !strcmp(a, "-42") && !strcmp(b, "ff") && !strcmp(c, "100000") && !strcmp(d, "  3.14") && !strcmp(e, "007|z|beef");
    good = good && strlcpy(f, "longer text", sizeof f) == 11 && !strcmp(f, "longe");
    strrev(f);
    good = good && !strcmp(f, "egnol") && strtol("77", 0, 8) == 63 && atoi("12abc") == 12;
    strupr(f);
    good = good && !strcmp(f, "EGNOL") && square(3) == 9;
    srandom(1);
    good = good && random() == 16807L && RANDOM_MAX == 0x7FFFFFFF;
}
void loop() { set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
