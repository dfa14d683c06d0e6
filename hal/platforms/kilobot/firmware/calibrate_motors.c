/* The robots' side of `arkmesh calibrate-motors`: moves as it is told, with the duties it is told, and keeps them at
   the end. Load it, RUN it. To one robot (messages of type 0, three blocks of id 10 bits, kind 4 bits, value 10 bits):
     1 value: turn left with this duty      2 value: turn right      3: stop; value 1: and keep nothing of this at the
   end 5 value: duty of the right motor       4 value: go straight, the left motor with this duty To all: 110 store the
   duties of turns, 111 those of straights, in the EEPROM, where kilolib looks for them at each start. LED: left red,
   right green, straight blue, stopped red; all stored green, of all colours not in use then the one that cameras know
   best. */
#include <arkmesh_id.h>
#include <avr/eeprom.h>
#include <kilolib.h>
#include <stdint.h>

enum {
  TURN_LEFT = 1,
  TURN_RIGHT = 2,
  STOP = 3,
  STRAIGHT = 4,
  RIGHT_DUTY = 5,
  STORE_TURNS = 110,
  STORE_STRAIGHTS = 111
};

/* Written by on_message. */
static volatile uint8_t wanted = STOP, gives_up;
static volatile uint8_t has_to_store_turns, has_to_store_straights;

static uint8_t motion, motion_left, motion_right; /* what the motors do */
static uint8_t stored;                            /* bit 0 turns, bit 1 straights */

/* Runs inside the receive interrupt. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type == STORE_TURNS) has_to_store_turns = 1;
  if (message->type == STORE_STRAIGHTS) has_to_store_straights = 1;
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t* block = message->data + i;
    const uint16_t robot = (uint16_t)((uint16_t)block[0] << 2 | block[1] >> 6);
    const uint8_t kind = block[1] >> 2 & 15, value = block[2];
    if (robot != kilo_uid) continue;
    switch (kind) {
      case TURN_LEFT:
        kilo_turn_left = value;
        wanted = kind;
        break;
      case TURN_RIGHT:
        kilo_turn_right = value;
        wanted = kind;
        break;
      case STOP:
        wanted = kind;
        gives_up = value;
        break;
      case STRAIGHT:
        kilo_straight_left = value;
        wanted = kind;
        break;
      case RIGHT_DUTY:
        kilo_straight_right = value;
        break;
    }
  }
}

static void move(uint8_t now) {
  uint8_t left = 0, right = 0;
  if (now == TURN_LEFT || now == STRAIGHT) left = now == STRAIGHT ? kilo_straight_left : kilo_turn_left;
  if (now == TURN_RIGHT || now == STRAIGHT) right = now == STRAIGHT ? kilo_straight_right : kilo_turn_right;
  if (now == motion && left == motion_left && right == motion_right) return;
  if (now != motion && now != STOP) spinup_motors();
  motion = now;
  motion_left = left;
  motion_right = right;
  set_motors(left, right);
  if (now == TURN_LEFT) set_color(RGB(3, 0, 0));
  if (now == TURN_RIGHT) set_color(RGB(0, 3, 0));
  if (now == STRAIGHT) set_color(RGB(0, 0, 3));
  if (now == STOP) set_color(RGB(3, 0, 0));
  if (now != STOP) stored = 0;
}

static void loop(void) {
  move(wanted);
  if (has_to_store_turns) {
    has_to_store_turns = 0;
    if (!gives_up && !(stored & 1)) {
      eeprom_write_byte((uint8_t*)0x05, kilo_turn_left);
      eeprom_write_byte((uint8_t*)0x09, kilo_turn_right);
      stored |= 1;
    }
  }
  if (has_to_store_straights) {
    has_to_store_straights = 0;
    if (!gives_up && !(stored & 2)) {
      eeprom_write_byte((uint8_t*)0x0C, kilo_straight_left);
      eeprom_write_byte((uint8_t*)0x14, kilo_straight_right);
      stored |= 2;
    }
  }
  if (stored == 3) set_color(RGB(0, 3, 0));
}

static void setup(void) {
  set_color(RGB(3, 0, 0));
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
