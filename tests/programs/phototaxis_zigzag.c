/* Towards the light in a zigzag: turns on the spot once to learn the darkest and the brightest reading, each a mean of 300 samples,
   then left while it is brighter than their middle and right while it is darker. The sensor sits on the left. */
#include <kilolib.h>

#define NUMBER_OF_SAMPLES 300
#define STOP 0
#define FORWARD 1
#define LEFT 2
#define RIGHT 3

int current_motion = STOP;
int current_light = 0;
int darkest = 1023, brightest = 0;
uint32_t learnt_at;

void set_motion(int new_motion)
{
    if (current_motion != new_motion) {
        current_motion = new_motion;
        if (current_motion == STOP) {
            set_motors(0, 0);
        } else if (current_motion == FORWARD) {
            spinup_motors();
            set_motors(kilo_straight_left, kilo_straight_right);
        } else if (current_motion == LEFT) {
            spinup_motors();
            set_motors(kilo_turn_left, 0);
        } else if (current_motion == RIGHT) {
            spinup_motors();
            set_motors(0, kilo_turn_right);
        }
    }
}

void sample_light()
{
    int number_of_samples = 0;
    long sum = 0;
    while (number_of_samples < NUMBER_OF_SAMPLES) {
        int sample = get_ambientlight();
        if (sample != -1) {
            sum = sum + sample;
            number_of_samples = number_of_samples + 1;
        }
    }
    current_light = sum / number_of_samples;
}

void setup()
{
    set_motion(LEFT);
    learnt_at = kilo_ticks + 10 * TICKS_PER_SEC;
}

void loop()
{
    sample_light();
    if (kilo_ticks < learnt_at) {
        if (current_light < darkest) darkest = current_light;
        if (current_light > brightest) brightest = current_light;
        return;
    }
    if (current_light > (darkest + brightest) / 2) {
        set_motion(LEFT);
        set_color(RGB(1, 0, 0));
    } else {
        set_motion(RIGHT);
        set_color(RGB(0, 0, 1));
    }
}

int main()
{
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
