/* What a robot of CRE decides, apart from all hardware: integers in, integers out, for AVR and for tests on a PC.
   North and south are alike in every function: swap them in what goes in, and they are swapped in what comes out. */
#ifndef CRE_DECISIONS_H
#define CRE_DECISIONS_H

#include <stdint.h>

#include "cre_messages.h"

/* Estimates are densities in 1/7500, so that readings (1/30) times shares (1/250) are whole numbers. */
#define CRE_ESTIMATE_PER_READING 250
#define CRE_ESTIMATE_ONE 7500u
#define CRE_UNKNOWN 0xFFFFu /* no place of the region was ever in sight */
/* A draw is uniform in 0 .. CRE_DRAWS - 1; what has probability p happens below p * CRE_DRAWS. */
#define CRE_DRAWS 1875000ul /* CRE_ESTIMATE_ONE * CRE_ONE */

struct cre_rules {
  uint8_t commit, recruit, weight; /* of CRE_ONE */
  uint16_t abandon;                /* of CRE_ABANDON_ONE */
};

/* v <- v + w (d - v), rounded to the nearest; the first reading sets it. `reading`: 0..CRE_FULL or CRE_NO_PLACE. */
static inline uint16_t cre_estimate(uint16_t estimate, uint8_t reading, uint8_t weight) {
  int32_t change;
  if (reading > CRE_FULL) return estimate;
  if (estimate == CRE_UNKNOWN) return (uint16_t)(reading * CRE_ESTIMATE_PER_READING);
  change = (int32_t)weight * ((int32_t)reading * CRE_ESTIMATE_PER_READING - (int32_t)estimate);
  change += change < 0 ? -CRE_ONE / 2 : CRE_ONE / 2;
  return (uint16_t)((int32_t)estimate + change / CRE_ONE);
}

/* Both densities of a reading (the value of the lab's message) into the estimates, the north's first. */
static inline void cre_take_densities(uint16_t estimates[2], uint16_t densities, uint8_t weight, uint8_t ignore_zero) {
  const uint8_t readings[2] = {(uint8_t)(densities >> 5 & 31), (uint8_t)(densities & 31)};
  uint8_t i;
  for (i = 0; i < 2; ++i)
    if (readings[i] != 0 || !ignore_zero) estimates[i] = cre_estimate(estimates[i], readings[i], weight);
}

/* share * v in CRE_DRAWS. estimates[0] is the north's. */
static inline uint32_t cre_chance(uint8_t share, const uint16_t estimates[2], uint8_t region) {
  const uint16_t v = estimates[region - CRE_NORTH];
  return v == CRE_UNKNOWN ? 0 : (uint32_t)share * v;
}

/* min(1, a / v) in CRE_DRAWS. */
static inline uint32_t cre_abandon_chance(uint16_t abandon, uint16_t v) {
  uint32_t chance;
  if (abandon == 0) return 0;
  if (v == CRE_UNKNOWN || v == 0) return CRE_DRAWS;
  chance = abandon * (CRE_DRAWS * 3 / 4) / v; /* a v-th of CRE_DRAWS * CRE_ESTIMATE_ONE / CRE_ABANDON_ONE */
  return chance < CRE_DRAWS ? chance : CRE_DRAWS;
}

/* The opinion after a decision. `heard`: the last neighbour's since the decision before, or CRE_NONE. `tried`: the
   region that an uncommitted robot may commit to by itself, drawn evenly. */
static inline uint8_t cre_decide(const struct cre_rules* rules, uint8_t opinion, uint8_t heard, uint8_t tried,
                                 const uint16_t estimates[2], uint32_t draw) {
  uint32_t chance;
  if (opinion == CRE_NONE) {
    chance = cre_chance(rules->commit, estimates, tried);
    if (draw < chance) return tried;
    if (heard != CRE_NONE) chance += cre_chance(rules->recruit, estimates, heard);
    return draw < chance ? heard : (uint8_t)CRE_NONE;
  }
  chance = cre_abandon_chance(rules->abandon, estimates[opinion - CRE_NORTH]);
  if (heard != CRE_NONE && heard != opinion) chance += cre_chance(rules->recruit, estimates, heard);
  return draw < chance ? (uint8_t)CRE_NONE : opinion;
}

/* How far a robot turns to head for `region`, counter-clockwise, in 1024ths of a turn, at most half a turn either way.
   `heading` as the compass gives it. The south is the north in a mirror. */
static inline int16_t cre_turn_towards(uint8_t region, uint16_t heading) {
  const uint16_t mirrored = region == CRE_NORTH ? heading : (uint16_t)(CRE_TURN - heading);
  const uint16_t turn = (uint16_t)(CRE_TURN / 4 + CRE_TURN / 2 - mirrored) & (CRE_TURN - 1);
  const int16_t left = (int16_t)((int16_t)turn - CRE_TURN / 2);
  return region == CRE_NORTH ? left : (int16_t)-left;
}

#endif
