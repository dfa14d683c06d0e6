/* An art piece: a dance of six figures, nested functions and delays, started by the first message that anyone says; robot 0 says
   it after five seconds. The rest joins in as the word passes from robot to robot. */
#include <kilolib.h>

volatile int dancing = 0;
message_t start_word;

void rx(message_t *m, distance_measurement_t *d) { if (m->data[0] == 42) dancing = 1; }
message_t *tx() { return dancing ? &start_word : 0; }

void turn_left(int ms) { spinup_motors(); set_motors(kilo_turn_left, 0); delay(ms); set_motors(0, 0); }
void turn_right(int ms) { spinup_motors(); set_motors(0, kilo_turn_right); delay(ms); set_motors(0, 0); }
void forward(int ms) { spinup_motors(); set_motors(kilo_straight_left, kilo_straight_right); delay(ms); set_motors(0, 0); }

void sparkle(int times) {
    int i;
    for (i = 0; i < times; i++) {
        set_color(RGB(3, 3, 3));
        delay(50);
        set_color(RGB(0, 0, 0));
        delay(50);
    }
}

void figure_one() { set_color(RGB(3, 0, 0)); turn_left(3000); forward(1000); }
void figure_two() { set_color(RGB(0, 3, 0)); turn_right(3000); forward(1000); }
void figure_three() { int i; for (i = 0; i < 4; i++) { set_color(RGB(0, 0, 3)); turn_left(500); set_color(RGB(3, 0, 3)); turn_right(500); } }

void setup() {
    start_word.type = NORMAL;
    start_word.data[0] = 42;
    start_word.crc = message_crc(&start_word);
}

void loop() {
    if (!dancing) {
        if (kilo_uid == 0 && kilo_ticks > 5 * 32) dancing = 1;
        return;
    }
    figure_one();
    sparkle(5);
    figure_two();
    sparkle(5);
    figure_three();
    delay(2000);
}

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
