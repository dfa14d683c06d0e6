#include "kilolib.h"
#include <stdlib.h>

static char* volatile piece;

static void setup(void) {}
static void loop(void) {
    if (kilo_ticks < 40 || kilo_uid != 2) return;
    piece = malloc(20);
    free(piece);
    free(piece); /* line 11 */
}
int main(void) {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
