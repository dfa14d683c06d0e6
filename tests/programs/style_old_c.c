/* Style: C of 1978. Callbacks with empty parentheses that take arguments, parameters declared below, no return types. */
#include <kilolib.h>

static message_t m;
static count;

static add(a, b)
int a, b;
{
    return a + b;
}

rx()
{
    count = add(count, 1);
}

message_t *tx()
{
    m.type = NORMAL;
    m.crc = message_crc(&m);
    return &m;
}

setup()
{
    set_color(RGB(3, 0, 0));
}

loop()
{
    if (count > 3) set_color(RGB(0, 3, 0));
}

main()
{
    kilo_init();
    kilo_message_rx = (message_rx_t)rx;
    kilo_message_tx = tx;
    kilo_start((void (*)(void))setup, (void (*)(void))loop);
}
