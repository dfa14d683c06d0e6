/* Style: prints with debug.h, DEBUG defined, in setup and now and then in loop. */
#define DEBUG
#include <kilolib.h>
#include <debug.h>

uint32_t next = 0;
static char buffer[40];

void setup() {
    debug_init();
    printf("robot %u is here\n", kilo_uid);
}

void loop() {
    if (kilo_ticks < next) return;
    next = kilo_ticks + 310;
    snprintf(buffer, sizeof buffer, "tick %lu, %d", (unsigned long)kilo_ticks, get_ambientlight());
    puts(buffer);
    putchar('\n');
    set_color(buffer[0] == 't' ? RGB(0, 3, 0) : RGB(3, 0, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
