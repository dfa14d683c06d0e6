/* Style: keeps numbers in the EEPROM: bytes, words, blocks, variables placed there; reads the robot's own id and calibration from it. */
#include <avr/eeprom.h>
#include <kilolib.h>
uint8_t EEMEM saved_byte;
uint16_t EEMEM saved_word;
uint8_t good = 0;
struct { uint8_t a; uint16_t b; } block = { 3, 500 }, copy;
void setup() {
    good = eeprom_read_byte((uint8_t *)0x200) == 0xFF;
    eeprom_write_byte((uint8_t *)0x200, 17);
    eeprom_update_word((uint16_t *)0x202, 40000);
    eeprom_write_dword((uint32_t *)0x210, 123456789UL);
    eeprom_write_block(&block, (void *)0x220, sizeof block);
    eeprom_busy_wait();
    eeprom_read_block(&copy, (const void *)0x220, sizeof copy);
    good = good && eeprom_read_byte((const uint8_t *)0x200) == 17 && eeprom_read_word((const uint16_t *)0x202) == 40000 &&
           eeprom_read_dword((const uint32_t *)0x210) == 123456789UL && copy.a == 3 && copy.b == 500;
    good = good && (eeprom_read_byte((uint8_t *)0xB0) | eeprom_read_byte((uint8_t *)0xB1) << 8) == kilo_uid;
    good = good && eeprom_read_byte((uint8_t *)0x05) == kilo_turn_left && eeprom_read_byte((uint8_t *)0x14) == kilo_straight_right;
    eeprom_write_byte(&saved_byte, 9);
    eeprom_write_word(&saved_word, 999);
    good = good && eeprom_read_byte(&saved_byte) == 9 && eeprom_read_word(&saved_word) == 999 && eeprom_is_ready();
}
void loop() { set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0)); }
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
