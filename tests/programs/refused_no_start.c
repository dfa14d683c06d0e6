/* Never calls kilo_start. */
#include <kilolib.h>

void setup() {}
void loop() {}

int main() {
    kilo_init();
    return 0;
}
