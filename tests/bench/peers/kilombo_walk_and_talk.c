/* controllers/walk_and_talk.c in the form that Kilombo wants, in a square arena of SIDE_MM that clamps. */
#include <kilombo.h>

#include <stdlib.h>

typedef struct {
  message_t out;
  uint8_t heard, nearest;
  uint32_t next;
} robot_t;

REGISTER_USERDATA(robot_t)

static message_t *tx() { return &mydata->out; }
static void rx(message_t *m, distance_measurement_t *d) {
  const uint8_t mm = estimate_distance(d);
  mydata->heard = m->data[0];
  if (mm < mydata->nearest) mydata->nearest = mm;
}
static void setup() {
  mydata->out.type = NORMAL;
  mydata->out.data[0] = kilo_uid;
  mydata->out.crc = message_crc(&mydata->out);
}
static void loop() {
  if (kilo_ticks < mydata->next) return;
  mydata->next = kilo_ticks + 15 + rand() % 16;
  spinup_motors();
  switch (rand() & 3) {
    case 0: set_motors(kilo_turn_left, 0); break;
    case 1: set_motors(0, kilo_turn_right); break;
    default: set_motors(kilo_straight_left, kilo_straight_right);
  }
}

static double outside(double at) {
  const double most = SIDE_MM / 2.0 - 17;
  return at > most ? most - at : at < -most ? -most - at : 0;
}
static int16_t walls(double x, double y, double *push_x, double *push_y) {
  *push_x = outside(x);
  *push_y = outside(y);
  return *push_x != 0 || *push_y != 0;
}

int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  SET_CALLBACK(obstacles, walls);
  kilo_start(setup, loop);
  return 0;
}
