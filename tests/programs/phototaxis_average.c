/* Phototaxis as the labs teach it: averages 300 readings of the sensor in one go, skipping those that fail; turns one way until the light
   falls below a threshold, then the other. */
#include <kilolib.h>
#include <math.h>
#define NUMBER_OF_SAMPLES 300
#define THRESH_LO 300
#define THRESH_HI 600
#define STOP 0
#define LEFT 2
#define RIGHT 3
int current_motion = STOP;
int current_light = 0;

void set_motion(int new_motion) {
    if (current_motion == new_motion) return;
    current_motion = new_motion;
    if (current_motion == STOP) { set_motors(0, 0); }
    else if (current_motion == LEFT) { spinup_motors(); set_motors(kilo_turn_left, 0); }
    else { spinup_motors(); set_motors(0, kilo_turn_right); }
}

void sample_light() {
    int number_of_samples = 0;
    int sum = 0;
    while (number_of_samples < NUMBER_OF_SAMPLES) {
        int sample = get_ambientlight();
        if (sample != -1) {
            sum = sum + sample;
            number_of_samples = number_of_samples + 1;
        }
    }
    current_light = floor(sum / (float)number_of_samples + 0.5);
}

void setup() { set_motion(LEFT); }

void loop() {
    sample_light();
    if (current_light < THRESH_LO) { set_motion(RIGHT); set_color(RGB(1, 0, 0)); }
    else if (current_light > THRESH_HI) { set_motion(LEFT); set_color(RGB(0, 1, 0)); }
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
