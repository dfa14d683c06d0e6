/* Style: very old C: definitions with types after the names, implicit int, undeclared functions, main with arguments. Green. */
#include <kilolib.h>
counter;
static table[4] = { 1, 2, 3, 4 };
add(a, b)
int a, b;
{
    return a + b;
}
long scaled(x, by)
long x;
char by;
{
    return x * by;
}
setup()
{
    register i;
    for (i = 0; i < 4; i++) counter = add(counter, table[i]);
}
loop()
{
    set_color(counter == 10 && scaled(3L, 4) == 12 && later(5) == 6 ? RGB(0, 3, 0) : RGB(3, 0, 0));
}
int later(int x) { return x + 1; }
main(argc, argv)
int argc;
char **argv;
{
    if (argc > 1) counter = 100;
    kilo_init();
    kilo_start(setup, loop);
}
