#include "kilolib.h"
#include <string.h>

static char small[4];
static const char* volatile words = "too long";

static void setup(void) {}
static void loop(void) {
    /* what a compiler that fortifies makes of strcpy(small, words) */
    __builtin___strcpy_chk(small, words, sizeof small);
}
int main(void) {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
