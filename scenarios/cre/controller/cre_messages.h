// What the CRE scenario tells robots, and what flying robots tell each other. Shared by the scenario (C++) and the
// robots' programs (C, also for AVR).
#ifndef CRE_MESSAGES_H
#define CRE_MESSAGES_H

#include <stdint.h>

// A region, or the opinion of a robot that is committed to it.
enum cre_region { CRE_NONE = 0, CRE_NORTH = 1, CRE_SOUTH = 2 };

// Where a robot's wall is. A robot hears of walls in front of it only.
enum cre_wall { CRE_NO_WALL = 0, CRE_WALL_LEFT = 1, CRE_WALL_RIGHT = 2, CRE_WALL_AHEAD = 3 };

// Messages to single robots. A flying robot has one slot: a reading of its sensors. Kind: enum cre_wall. Value: density
// of the north and of the south, 5 bits each, of CRE_FULL; CRE_NO_PLACE where no place of the region is in sight.
enum { CRE_READING_SLOT = 0, CRE_FULL = 30, CRE_NO_PLACE = 31 };

// A ground robot has two slots: what it hears from flying robots, and walls.
// Walls: kind enum cre_wall, value 0. Heard: the robot's compass, its heading from east, counter-clockwise, in 1024ths
// of a turn.
enum { CRE_WALL_SLOT = 0, CRE_HEARD_SLOT = 1, CRE_HEARD_NORTH = 4, CRE_HEARD_SOUTH = 5, CRE_TURN = 1024 };

// Types of infrared messages beside the lab's (0).
enum { CRE_TYPE_RULES = 2, CRE_TYPE_OPINION = 3 };

// CRE_TYPE_OPINION, from a committed flying robot to its neighbours: byte 0 is its region.

// CRE_TYPE_RULES, from the lab to all robots: what the experiment's configuration says about their behaviour.
enum cre_rules_byte {
  CRE_RULE_COMMIT = 0,    // h: share of the density, of CRE_ONE
  CRE_RULE_RECRUIT = 1,   // k: likewise, for recruitment and cross-inhibition
  CRE_RULE_WEIGHT = 2,    // w: of a reading in the estimate, of CRE_ONE
  CRE_RULE_ABANDON = 3,   // a: of CRE_ABANDON_ONE, two bytes, high one first; at most CRE_ABANDON_MAX
  CRE_RULE_DECISION = 5,  // tau: time between decisions, in tenths of a second
  CRE_RULE_FLAGS = 6,     // enum cre_flags
  CRE_RULE_STRAIGHT = 7   // how long a ground robot goes straight, in tenths of a second
};
enum { CRE_ONE = 250, CRE_ABANDON_ONE = 10000, CRE_ABANDON_MAX = 3000 };
enum cre_flags {
  CRE_TOGETHER = 1,     // all robots decide at the same time; otherwise each in a phase of its own
  CRE_IGNORE_ZERO = 2,  // a density of zero is no reading
  CRE_SAY_ONCE = 4      // an opinion is sent once after each decision; otherwise twice a second
};

#endif
