/* Each robot writes files, reads one of them again, and prints. */
#include "kilolib.h"
#include <stdio.h>

static void setup(void) {
  char name[30];
  int number = 0;
  snprintf(name, sizeof name, "logs/log_%d.tsv", kilo_uid);
  FILE* out = fopen(name, "w");
  FILE* kept = fopen("/../../outside.txt", "w");
  if (!out || !kept) return;
  fprintf(out, "%d\t%s\n", kilo_uid + 7, "text");
  fwrite("ab\0cd", 1, 5, out);
  fclose(out);
  fputs("left open", kept);
  FILE* in = fopen(name, "r");
  if (in && fscanf(in, "%d", &number) == 1 && number == kilo_uid + 7) set_color(RGB(0, 1, 0));
  printf("robot %d says %ld\n", kilo_uid, 70000L);
}
static void loop(void) {}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
