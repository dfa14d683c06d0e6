/* Exercise in calibration: one motor after the other at rising power, a colour for each, then both; all the time inside loop(). */
#include <kilolib.h>

void setup() {}

void loop()
{
    int power;
    set_color(RGB(1, 0, 0));
    for (power = 50; power <= 90; power += 10)
    {
        spinup_motors();
        set_motors(power, 0);
        delay(1000);
    }
    set_motors(0, 0);
    delay(500);
    set_color(RGB(0, 1, 0));
    for (power = 50; power <= 90; power += 10)
    {
        spinup_motors();
        set_motors(0, power);
        delay(1000);
    }
    set_motors(0, 0);
    delay(500);
    set_color(RGB(0, 0, 1));
    spinup_motors();
    set_motors(kilo_straight_left, kilo_straight_right);
    delay(2000);
    set_motors(0, 0);
    set_color(RGB(0, 0, 0));
    delay(500);
}

int main()
{
    kilo_init();
    kilo_start(setup, loop);
}
