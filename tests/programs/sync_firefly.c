/* Fireflies: everybody has a phase of four seconds, flashes red at its end, and hearing a flash moves the own phase forward. */
#include <kilolib.h>

#define PERIOD 128
#define FLASH 10
#define PUSH 6

uint32_t start_of_cycle = 0;
uint8_t flashed_for = 0;     /* messages left that say: I have just flashed */
volatile uint8_t pushes = 0;
message_t flash_message;

void setup() {
    uint8_t offset = rand_hard();
    start_of_cycle = kilo_ticks - offset / 2;
    flash_message.type = NORMAL;
    flash_message.crc = message_crc(&flash_message);
}

void loop() {
    uint32_t phase = kilo_ticks - start_of_cycle;
    if (phase < PERIOD && pushes) {
        /* The later in the cycle, the stronger. Right after the own flash nobody is listened to. */
        if (phase > 24 && phase < PERIOD - 1) start_of_cycle -= 1 + pushes * phase / (PERIOD / PUSH);
        pushes = 0;
        phase = kilo_ticks - start_of_cycle;
    }
    if (phase >= PERIOD) {
        start_of_cycle = kilo_ticks;
        flashed_for = 1;
        set_color(RGB(3, 0, 0));
    } else if (phase > FLASH) {
        set_color(RGB(0, 0, 0));
    }
}

message_t *message_tx() { return flashed_for ? &flash_message : 0; }
void message_tx_success() { flashed_for = 0; }
void message_rx(message_t *m, distance_measurement_t *d) { pushes++; }

int main() {
    kilo_init();
    kilo_message_tx = message_tx;
    kilo_message_tx_success = message_tx_success;
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
