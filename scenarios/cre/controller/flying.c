/* The flying robot of CRE, a plain kilolib program: the same file runs in the simulator and on a Kilobot.
   Walks at random over both regions, estimates the density of resources in each from what the lab tells it, and becomes
   committed to one of them (LED: off uncommitted, red north, blue south), alone or recruited by a neighbour; leaves its
   opinion by itself, or inhibited by a neighbour of the other one. */
#include <arkmesh_id.h>
#include <kilolib.h>
#include <stdint.h>
#include <string.h>

#include "cre_decisions.h"
#include "cre_messages.h"
#include "cre_walk.h"

/* Written by on_message only. */
static volatile uint8_t heard_wall;
static volatile uint16_t heard_densities;
static volatile uint8_t heard_count;
static volatile uint8_t heard_opinion; /* the last neighbour's; taken at a decision */
static volatile uint8_t heard_rules[CRE_RULE_FLAGS + 1];
static volatile uint8_t rules_count;

/* Read by next_message. */
static message_t opinion_message;
static volatile uint8_t sends_opinion;

static uint8_t seen_count, seen_rules;
static struct cre_rules rules = {CRE_ONE / 5, 4 * CRE_ONE / 5, CRE_ONE / 10, CRE_ABANDON_ONE / 100};
static uint8_t flags;
static uint16_t decision_ticks = 305;
static uint8_t opinion;
static uint16_t estimates[2] = {CRE_UNKNOWN, CRE_UNKNOWN}; /* north, south */
static uint32_t decides_at;

/* Uniform below CRE_DRAWS: 21 bits, drawn again when they are more. */
static uint32_t draw(void) {
  uint32_t bits;
  do {
    bits = random_word() >> 11;
  } while (bits >= CRE_DRAWS);
  return bits;
}

static void set_opinion(uint8_t region) {
  opinion = region;
  set_color(opinion == CRE_NORTH ? RGB(3, 0, 0) : opinion == CRE_SOUTH ? RGB(0, 0, 3) : RGB(0, 0, 0));
  /* The timer's interrupt sends nothing while the message changes. */
  sends_opinion = 0;
  if (opinion == CRE_NONE) return;
  opinion_message.type = CRE_TYPE_OPINION;
  opinion_message.data[0] = opinion;
  opinion_message.crc = message_crc(&opinion_message);
  sends_opinion = 1;
}

static void decide(void) {
  const uint8_t tried = random_word() >> 31 ? CRE_NORTH : CRE_SOUTH;
  const uint8_t heard = heard_opinion;
  heard_opinion = CRE_NONE;
  set_opinion(cre_decide(&rules, opinion, heard, tried, estimates, draw()));
}

/* The next decision is within one time between decisions, at once where all robots decide together. */
static void begin_deciding(uint32_t now) {
  decides_at = now + (flags & CRE_TOGETHER ? decision_ticks : (uint16_t)(random_unit() * decision_ticks));
}

static void take_rules(uint32_t now, const uint8_t* told) {
  static uint8_t known[CRE_RULE_FLAGS + 1];
  if (memcmp(known, told, sizeof known) == 0) return;
  memcpy(known, told, sizeof known);
  rules.commit = told[CRE_RULE_COMMIT];
  rules.recruit = told[CRE_RULE_RECRUIT];
  rules.weight = told[CRE_RULE_WEIGHT];
  rules.abandon = (uint16_t)told[CRE_RULE_ABANDON] << 8 | told[CRE_RULE_ABANDON + 1];
  decision_ticks = ticks_of_tenths(told[CRE_RULE_DECISION]);
  flags = told[CRE_RULE_FLAGS];
  begin_deciding(now);
}

/* What came since the last call; read again when something comes in between. */
static void take_messages(uint32_t now) {
  if (seen_count != heard_count) {
    uint8_t wall_told;
    uint16_t densities;
    do {
      seen_count = heard_count;
      wall_told = heard_wall;
      densities = heard_densities;
    } while (seen_count != heard_count);
    hear_wall(now, wall_told);
    cre_take_densities(estimates, densities, rules.weight, flags & CRE_IGNORE_ZERO);
  }
  if (seen_rules != rules_count) {
    uint8_t told[CRE_RULE_FLAGS + 1], i;
    do {
      seen_rules = rules_count;
      for (i = 0; i < sizeof told; ++i) told[i] = heard_rules[i];
    } while (seen_rules != rules_count);
    take_rules(now, told);
  }
}

static void loop(void) {
  const uint32_t now = ticks();
  take_messages(now);
  if (is_over(decides_at, now)) {
    /* Once, however long the robot was paused; its phase stays. */
    do {
      decides_at += decision_ticks;
    } while (is_over(decides_at, now));
    decide();
  }
  if (!avoid_wall(now)) walk(now);
}

/* An overhead message holds three blocks of 24 bits: robot 10, kind 4, value 10. Runs inside the receive interrupt. */
static void on_message(message_t* message, distance_measurement_t* distance) {
  uint8_t i;
  (void)distance;
  if (message->type == CRE_TYPE_OPINION) {
    if (message->data[0] == CRE_NORTH || message->data[0] == CRE_SOUTH) heard_opinion = message->data[0];
  } else if (message->type == CRE_TYPE_RULES) {
    for (i = 0; i < sizeof heard_rules; ++i) heard_rules[i] = message->data[i];
    ++rules_count;
  } else if (message->type == NORMAL) {
    for (i = 0; i < 9; i += 3) {
      const uint8_t* block = message->data + i;
      const uint16_t robot = (uint16_t)block[0] << 2 | block[1] >> 6;
      if (robot != kilo_uid) continue;
      heard_wall = block[1] >> 2 & 3;
      heard_densities = (uint16_t)(block[1] & 3) << 8 | block[2];
      ++heard_count;
    }
  }
}

/* Asked by the timer's interrupt, about twice a second. */
static message_t* next_message(void) {
  return sends_opinion ? &opinion_message : 0;
}

static void on_sent(void) {
  if (flags & CRE_SAY_ONCE) sends_opinion = 0;
}

static void setup(void) {
  set_up_random();
  begin_deciding(ticks());
  set_opinion(CRE_NONE);
  go_ahead(ticks());
}

int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_message_tx = next_message;
  kilo_message_tx_success = on_sent;
  kilo_start(setup, loop);
  return 0;
}
