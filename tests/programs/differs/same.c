/* Does the same on a robot, in messages, delays, readings and waits for the clock. */
#include <avr/eeprom.h>
#include <kilolib.h>
#include <math.h>
#include <stdlib.h>
message_t out;
float x, y, heading;
uint16_t heard[4];
int16_t way;
uint32_t next;
struct {
  uint8_t id;
  int16_t distance;
} nearest[3];
message_t *send() {
  out.data[0] = kilo_uid;
  out.data[1] = rand() & 7;
  out.crc = message_crc(&out);
  return &out;
}
void sent() { heard[3]++; }
void hear(message_t *m, distance_measurement_t *d) {
  uint8_t i = m->data[1] % 3;
  nearest[i].id = m->data[0];
  nearest[i].distance = estimate_distance(d);
  heard[i]++;
}
void setup() { rand_seed(rand_hard()); }
void loop() {
  static uint8_t step;
  heading += 0.1f;
  x += cos(heading);
  y += sin(heading);
  switch (step++ % 4) {
    case 0:
      spinup_motors();
      set_motors(kilo_straight_left, kilo_straight_right);
      delay(150);
      break;
    case 1:
      way += rand_soft() - 128;
      set_color(way & 63);
      break;
    case 2:
      next = kilo_ticks + 8;
      while (kilo_ticks < next) continue;
      break;
    default:
      set_motors(get_ambientlight() & 127, 0);
      eeprom_update_byte((uint8_t *)512, eeprom_read_byte((uint8_t *)512) + 1);
      heard[0] = eeprom_read_byte((uint8_t *)512);
  }
}
int main() {
  kilo_init();
  kilo_message_rx = hear;
  kilo_message_tx = send;
  kilo_message_tx_success = sent;
  kilo_start(setup, loop);
  return 0;
}
