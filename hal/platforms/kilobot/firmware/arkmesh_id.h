/* Lets a robot say who it is. One line makes any Kilobot program able to:

       #include "arkmesh_id.h"

   after kilolib.h, in the file that calls kilo_start. Nothing else changes: the program's kilo_start, set_motors,
   set_color and spinup_motors go through this header, which answers the overhead controller's questions in front of the
   program.

   While a robot is asked it stands still, its LED is the answer, its loop is not called, and kilo_ticks does not pass
   as far as the program can tell. Afterwards colour and motors are what the program last wanted. Without a question for
   3 s it goes on by itself. It answers in every state, before RUN too. Messages that are no questions reach the program
   as ever.

   A pause (WAKEUP) cuts motors and LED, and RUN brings neither back. So a robot whose loop has not been called for a
   while gets colour and motors again as the program last wanted them, with a spin-up where a motor runs. Kilo_ticks
   tells: it goes on in a pause. It stands still in deep sleep, so after SLEEP say WAKEUP before RUN. A pause that
   begins and ends within one call of loop stays unseen.

   Questions (docs/identification.md):
     118        one digit of the id in base 3: 0 red, 1 green, 2 blue. data[0]: bits 0..5 which digit (0..10 of the id,
   least significant first; 11..13 of its check word), bits 6..7 who is asked: 0 nobody (it is over), 1 everybody, 2 ids
   data[1..2] to data[3..4], 3 the four ids data[1..2], [3..4], [5..6], [7..8]. All big endian. 119, 120   ARK's: the
   robot whose id is data[0..1], big endian, is blue, all others red; 0xFFFF: it is over. Needs about 820 bytes of flash
   and 19 of RAM (avr-gcc 5.4, -Os). For one file of a program only. */
#ifndef ARKMESH_ID_H
#define ARKMESH_ID_H

#include <kilolib.h>

#define ARKMESH_ID_QUESTION 118
#define ARKMESH_ID_ARK_RUNTIME 119
#define ARKMESH_ID_ARK_INITIAL 120
#define ARKMESH_ID_PATIENCE_TICKS 92
/* An idle robot's library looks every 201 ms, 6 ticks, whether it is to run. While a robot runs, hardly more than one
   tick passes between two calls of loop, and one more for each message of its own that found the channel busy. */
#define ARKMESH_ID_PAUSE_TICKS 5

/* Simulated robots have no interrupts between two statements. */
#ifdef __AVR__
#define arkmesh_id_interrupts(instruction) __asm__ __volatile__(instruction ::: "memory")
#else
#define arkmesh_id_interrupts(instruction) ((void)0)
#endif

enum { arkmesh_id_free, arkmesh_id_asked, arkmesh_id_over };
enum { arkmesh_id_no_question = 254, arkmesh_id_not_me = 255 };

static volatile uint8_t arkmesh_id_phase;    /* over: the loop has yet to start the motors again */
static volatile uint8_t arkmesh_id_heard_at; /* low byte of kilo_ticks */
static uint8_t arkmesh_id_left, arkmesh_id_right, arkmesh_id_colour; /* what the program wants */
static uint32_t arkmesh_id_since;                                    /* kilo_ticks when the robot was first asked */
static uint32_t arkmesh_id_ran_at; /* kilo_ticks when the program's setup or loop returned */
static message_rx_t arkmesh_id_program_rx;
static void (*arkmesh_id_program_setup)(void);
static void (*arkmesh_id_program_loop)(void);

/* ---- what the program calls ---- */

static inline void arkmesh_id_set_motors(uint8_t left, uint8_t right) {
  arkmesh_id_left = left;
  arkmesh_id_right = right;
  if (arkmesh_id_phase != arkmesh_id_asked) set_motors(left, right);
}
static inline void arkmesh_id_set_color(uint8_t colour) {
  arkmesh_id_colour = colour;
  if (arkmesh_id_phase != arkmesh_id_asked) set_color(colour);
}
static inline void arkmesh_id_spinup_motors(void) {
  if (arkmesh_id_phase != arkmesh_id_asked) spinup_motors();
}

/* ---- questions ---- */

static inline uint16_t arkmesh_id_number(const uint8_t* bytes) {
  return (uint16_t)((uint16_t)bytes[0] << 8 | bytes[1]);
}

static inline uint8_t arkmesh_id_is_asked(const uint8_t* data) {
  uint8_t i;
  switch (data[0] >> 6) {
    case 1:
      return 1;
    case 2:
      return arkmesh_id_number(data + 1) <= kilo_uid && kilo_uid <= arkmesh_id_number(data + 3);
    case 3:
      for (i = 1; i < 9; i += 2)
        if (arkmesh_id_number(data + i) == kilo_uid) return 1;
  }
  return 0;
}

/* The colour that answers a question. The check word is the id modulo 23, spread over the three-digit numbers in base 3
   whose digits are not all equal: a LED that never changes is no id. */
static inline uint8_t arkmesh_id_answer(const message_t* message) {
  uint16_t rest = kilo_uid;
  uint8_t digit;
  if (message->type == ARKMESH_ID_ARK_RUNTIME || message->type == ARKMESH_ID_ARK_INITIAL) {
    rest = arkmesh_id_number(message->data);
    return rest == 0xFFFFu ? arkmesh_id_not_me : rest == kilo_uid ? 0x30 : 0x03;
  }
  if (message->type != ARKMESH_ID_QUESTION) return arkmesh_id_no_question;
  if (!arkmesh_id_is_asked(message->data)) return arkmesh_id_not_me;
  digit = message->data[0] & 63;
  if (digit > 10) {
    digit -= 11;
    rest %= 23;
    rest += rest < 12 ? 1 : 2;
  }
  for (; digit; --digit) rest /= 3;
  return (uint8_t)(3 << 2 * (rest % 3));
}

/* With interrupts off. */
static inline void arkmesh_id_end(void) {
  kilo_ticks = arkmesh_id_since;
  arkmesh_id_phase = arkmesh_id_over;
  set_color(arkmesh_id_colour);
}

/* Runs inside the receive interrupt. Says everything again at each copy of a question: an idle robot's library blinks,
   and a program may have been between looking at the phase and setting its motors. */
static inline void arkmesh_id_on_message(message_t* message, distance_measurement_t* distance) {
  const uint8_t answer = arkmesh_id_answer(message);
  if (answer == arkmesh_id_no_question) {
    if (arkmesh_id_program_rx) arkmesh_id_program_rx(message, distance);
    return;
  }
  if (answer == arkmesh_id_not_me) {
    if (arkmesh_id_phase == arkmesh_id_asked) arkmesh_id_end();
    return;
  }
  if (arkmesh_id_phase != arkmesh_id_asked) arkmesh_id_since = kilo_ticks;
  arkmesh_id_phase = arkmesh_id_asked;
  arkmesh_id_heard_at = (uint8_t)kilo_ticks;
  set_motors(0, 0);
  set_color(answer);
}

/* ---- in place of the program's loop and start ---- */

static inline void arkmesh_id_listen(void) {
  if (kilo_message_rx == arkmesh_id_on_message) return;
  arkmesh_id_program_rx = kilo_message_rx;
  kilo_message_rx = arkmesh_id_on_message;
}

static inline uint32_t arkmesh_id_ticks(void) {
  uint32_t now;
  arkmesh_id_interrupts("cli");
  now = kilo_ticks;
  arkmesh_id_interrupts("sei");
  return now;
}

/* In place of the program's setup. */
static inline void arkmesh_id_setup(void) {
  arkmesh_id_program_setup();
  arkmesh_id_ran_at = arkmesh_id_ticks();
}

static inline void arkmesh_id_loop(void) {
  uint8_t restores;
  arkmesh_id_listen(); /* the program may have set its callback in setup */
  if (arkmesh_id_phase == arkmesh_id_asked) {
    if ((uint8_t)((uint8_t)kilo_ticks - arkmesh_id_heard_at) < ARKMESH_ID_PATIENCE_TICKS) return;
    arkmesh_id_interrupts("cli");
    arkmesh_id_end();
    arkmesh_id_interrupts("sei");
  }
  /* signed: a program may set kilo_ticks back */
  restores = (int32_t)(arkmesh_id_ticks() - arkmesh_id_ran_at) >= ARKMESH_ID_PAUSE_TICKS;
  if (arkmesh_id_phase == arkmesh_id_over) {
    arkmesh_id_phase = arkmesh_id_free;
    restores = 1;
  }
  if (restores) {
    arkmesh_id_set_color(arkmesh_id_colour);
    if (arkmesh_id_left || arkmesh_id_right) arkmesh_id_spinup_motors();
    arkmesh_id_set_motors(arkmesh_id_left, arkmesh_id_right);
  }
  arkmesh_id_program_loop();
  arkmesh_id_ran_at = arkmesh_id_ticks();
}

static inline void arkmesh_id_start(void (*setup)(void), void (*loop)(void)) {
  arkmesh_id_program_setup = setup;
  arkmesh_id_program_loop = loop;
  arkmesh_id_listen();
  kilo_start(arkmesh_id_setup, arkmesh_id_loop);
}

#define set_motors(left, right) arkmesh_id_set_motors(left, right)
#define set_color(colour) arkmesh_id_set_color(colour)
#define spinup_motors() arkmesh_id_spinup_motors()
#define kilo_start(setup, loop) arkmesh_id_start(setup, loop)

#endif
