/* Of style_parts.c: tentative definitions in a header that is included twice. */
#include <kilolib.h>

int step_count;
uint8_t shown;
message_t parts_message;

void step();
void show(uint8_t color);
