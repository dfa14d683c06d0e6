/* Drives a motor by writing to the timer's compare register, past the library. */
#include <avr/io.h>
#include <kilolib.h>
void setup() {}
void loop() {
    OCR2A = 70;
}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
