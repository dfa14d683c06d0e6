#include <kilolib.h>
void setup() {}
void loop() { set_color(nonsense); }
int main() { kilo_init(); kilo_start(setup, loop); }
