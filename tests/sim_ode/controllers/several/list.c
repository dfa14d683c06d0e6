/* Static variables here, as in main.c, are each robot's own. */
#include "list.h"

static struct { int number; } list[20];
static int length = 0;

void list_add(int number) {
    if (length < 20) list[length++].number = number;
}

int list_sum(void) {
    int sum = 0, i;
    for (i = 0; i < length; i++) sum += list[i].number;
    return sum;
}
