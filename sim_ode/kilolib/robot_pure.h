/* What the library computes by itself: the same for a simulated robot and for the robot's own processor, where an int
   has 16 bits and a double is a float. Included once, after ROBOT and SPEND. */
ROBOT static uint8_t soft_state = 0xAA;
ROBOT static uint8_t soft_count = 0;
ROBOT static uint8_t measured = 0; /* estimate_distance() was called */

uint8_t rand_soft() {
  SPEND(5);
  soft_state ^= soft_state << 3;
  soft_state ^= soft_state >> 5;
  soft_state ^= soft_count++ >> 2;
  return soft_state;
}
void rand_seed(uint8_t seed) {
  soft_state = seed;
}

/* Infrared by ARGoS's rules: readings are millimetres, and no table says otherwise. */
static int by_argos(void) {
  return kilo_irlow[0] == 0;
}

uint16_t message_crc(const message_t* msg) {
  const uint8_t* byte = (const uint8_t*)msg;
  uint16_t crc = 0xFFFF;
  uint8_t i, bit;
  SPEND(150);
  if (by_argos()) return 0;
  for (i = 0; i < 10; i++) {
    crc ^= byte[i];
    for (bit = 0; bit < 8; bit++) crc = crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1;
  }
  return crc;
}

/* Gap in mm for a reading, on the straight line through table entries k-1 and k (k * 5 mm), truncated. */
static int32_t gap_mm(const uint16_t* table, int k, int32_t reading) {
  const int32_t slope = 2 * ((int32_t)table[k] - (int32_t)table[k - 1]);
  return slope == 0 ? 255 : (10 * (reading - (int32_t)table[k]) + 5 * slope * k) / slope;
}
/* The first entry that the reading exceeds, 14 when there is none. */
static int entry_below(const uint16_t* table, int32_t reading) {
  int k;
  for (k = 0; k < 14 && reading <= (int32_t)table[k]; k++) continue;
  return k;
}

uint8_t estimate_distance(const distance_measurement_t* dist) {
  const int high = dist->high_gain, low = dist->low_gain;
  uint8_t near_mm = 0, far_mm = 0;
  SPEND(400);
  measured = 1;
  if (by_argos()) return (uint8_t)high;
  if (high < 900) { /* high gain not saturated */
    const int k = entry_below(kilo_irhigh, high);
    if (k > 0) far_mm = (uint8_t)gap_mm(kilo_irhigh, k < 14 ? k : 13, high);
  }
  if (high > 700) { /* near enough for the low gain */
    const int k = entry_below(kilo_irlow, low);
    if (k > 0) near_mm = k < 14 ? (uint8_t)gap_mm(kilo_irlow, k, low) : 90;
  }
  if (high >= 900) return 33 + near_mm;
  if (high <= 700) return 33 + far_mm;
  return (uint8_t)(33 + (far_mm * (900.0 - high) + near_mm * (high - 700.0)) / 200.0);
}
