/* Of style_parts.c, which includes it. */
#include "shared.h"

void step() { step_count++; }
void show(uint8_t color) {
    shown = color;
    set_color(color);
}
