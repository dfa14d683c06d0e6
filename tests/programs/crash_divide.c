/* Divides by the number of neighbours, which is zero until someone is heard; nobody speaks. */
#include <kilolib.h>

volatile int neighbours = 0;
int mean = 0;

void setup() {}
void loop() {
    if (kilo_ticks > 31) mean = 1000 / neighbours;
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
