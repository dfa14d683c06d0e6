/* Style: states as a table of function pointers, strings, a const table in initialised data, recursion of moderate depth. */
#include <kilolib.h>
#include <string.h>

typedef void (*state_fn)(void);
static void state_wait(void);
static void state_go(void);
static void state_show(void);

static state_fn states[] = {state_wait, state_go, state_show};
static const char *names[] = {"wait", "go", "show"};
static uint8_t now = 0;
static uint32_t since = 0;
static message_t out = {{1, 2, 3, 4, 5, 6, 7, 8, 9}, NORMAL, 0xA718};

static uint16_t fibonacci(uint8_t n) { return n < 2 ? n : fibonacci(n - 1) + fibonacci(n - 2); }

static void to(uint8_t next) {
    now = next;
    since = kilo_ticks;
}
static void state_wait(void) { if (kilo_ticks - since > 31) to(1); }
static void state_go(void) {
    if (strcmp(names[now], "go") == 0 && fibonacci(10) == 55) to(2);
}
static void state_show(void) {
    set_color(message_crc(&out) == out.crc ? RGB(0, 3, 0) : RGB(3, 0, 0));
    if (kilo_ticks - since > 31) to(0);
}

void setup() { since = kilo_ticks; }
void loop() { states[now](); }

static message_t *tx() { return &out; }

int main() {
    kilo_init();
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
