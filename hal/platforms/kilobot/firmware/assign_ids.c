/* The robots' side of `arkmesh assign-ids`: takes a temporary id by chance, lets it be read (arkmesh_id.h), and stores
   the id it is given in the EEPROM, where kilolib looks for it at each start. Load it, RUN it, and leave the robots
   alone. Messages; ids are big endian: 1  data[0] session: draw a temporary id, once per session. 3  data[0..1]
   temporary id: whoever has it draws another one. 2  data[0..1] temporary id, [2..3] new id; and [4..5], [6..7]
   likewise: whoever has it stores the new one. Before the first: dark. With a temporary id: yellow. With a stored one:
   white. */
#include <arkmesh_id.h>
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <kilolib.h>
#include <stdint.h>

#define DRAW 1
#define STORE 2
#define DRAW_ANEW 3

#define FIRST_TEMPORARY 0x8000u
#define NOBODY 0xFFFFu
#define UID_PLACE ((uint8_t*)0xB0)

/* Written by on_message, cleared by loop. */
static volatile uint8_t has_to_draw, has_to_store;
static volatile uint8_t session, has_session;

static uint16_t number(const uint8_t* bytes) {
  return (uint16_t)((uint16_t)bytes[0] << 8 | bytes[1]);
}

/* Runs inside the receive interrupt. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  const uint8_t* data = message->data;
  uint8_t i;
  (void)distance;
  if (message->type == DRAW) {
    if (!has_session || session != data[0]) has_to_draw = 1;
    session = data[0];
    has_session = 1;
  } else if (message->type == DRAW_ANEW) {
    if (kilo_uid >= FIRST_TEMPORARY && number(data) == kilo_uid) has_to_draw = 1;
  } else if (message->type == STORE) {
    for (i = 0; i < 8; i += 4) {
      if (kilo_uid < FIRST_TEMPORARY || number(data + i) != kilo_uid || number(data + i + 2) >= FIRST_TEMPORARY)
        continue;
      kilo_uid = number(data + i + 2);
      has_to_store = 1;
      break;
    }
  }
}

static void loop(void) {
  if (has_to_draw) {
    uint16_t id = 0;
    do {
      id = (uint16_t)(FIRST_TEMPORARY | (uint16_t)rand_hard() << 8 | rand_hard());
    } while (id == NOBODY);
    cli();
    kilo_uid = id;
    has_to_draw = 0;
    sei();
    set_color(RGB(3, 3, 0));
  }
  if (has_to_store) {
    has_to_store = 0;
    eeprom_write_byte(UID_PLACE, (uint8_t)kilo_uid);
    eeprom_write_byte(UID_PLACE + 1, (uint8_t)(kilo_uid >> 8));
    set_color(RGB(3, 3, 3));
  }
}

static void setup(void) {
  set_color(RGB(0, 0, 0));
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
