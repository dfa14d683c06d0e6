/* For style_wait_include.c. */
static volatile char arrived;
void message_rx(message_t *in, distance_measurement_t *d) { arrived = 1; }
static void wait_for_message(void) {
    arrived = 0;
    while (!arrived) { }
}
