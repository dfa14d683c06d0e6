#include "kilolib.h"
#include <stdlib.h>

static void setup(void) {}
static void loop(void) {
    _Exit(0); /* line 6 */
}
int main(void) {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
