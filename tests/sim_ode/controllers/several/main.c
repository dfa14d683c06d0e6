/* A program of three files with headers of its own and of a folder beside it: waits in loop() until a broadcast has
   come, which another file notes, then shows the colour that a macro names, or white when its list is not as it
   should. */
#include "colour.h"
#include "list.h"
#include <kilolib.h>

static int rounds;

void setup() { set_color(RGB(0, 0, 0)); }

void loop() {
    int i;
    while (!heard) ;
    for (i = 0; i < 5; i++) list_add(kilo_uid + rounds++);
    set_color(list_sum() == 5 * kilo_uid + 10 ? COLOUR : RGB(3, 3, 3));
    heard = 0;
}

int main() {
    kilo_init();
    list_listen();
    kilo_start(setup, loop);
    return 0;
}
