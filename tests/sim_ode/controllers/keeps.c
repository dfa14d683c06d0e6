/* Counts its starts in the EEPROM, in a byte and in a variable, and shows them: red, green, blue, dark when they
   differ. A message of type 1 stores an id; one of type 2 shows whether the EEPROM holds the id and the duty of left
   turns that it says: white or dark. */
#include <avr/eeprom.h>
#include <kilolib.h>

#define STARTS ((uint8_t*)0x200)
#define UID ((uint16_t*)0xB0)
static uint8_t EEMEM also_starts;

static void hear(message_t* message, distance_measurement_t* distance) {
  (void)distance;
  if (message->type == 1) eeprom_write_word(UID, message->data[0]);
  if (message->type == 2)
    set_color(eeprom_read_word(UID) == message->data[0] && eeprom_read_byte((uint8_t*)0x05) == message->data[1]
                  ? RGB(3, 3, 3)
                  : RGB(0, 0, 0));
}
static void setup() {
  const uint8_t starts = (uint8_t)(eeprom_read_byte(STARTS) + 1);
  eeprom_write_byte(STARTS, starts);
  eeprom_write_byte(&also_starts, eeprom_read_byte(&also_starts) + 1);
  set_color(also_starts == starts + 1 ? 3 << 2 * starts : 0);
}
static void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = hear;
  kilo_start(setup, loop);
}
