#include "kilolib.h"
#include <signal.h>

static void setup(void) {}
static void loop(void) {
    raise(SIGTERM); /* line 6 */
}
int main(void) {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
