// What the DHTF scenario tells a robot. Shared by the scenario (C++) and the robot's program (C, also for AVR).
// All kinds exclude each other, so they share one slot: a newer one always replaces an unsent older one.
#ifndef DHTF_MESSAGES_H
#define DHTF_MESSAGES_H

enum dhtf_message {
  DHTF_OUTSIDE = 0,  // in no site. Value: wall sectors, 8 bits, bit 7 the leftmost of the front 180 degrees
  DHTF_TASK = 1,     // in a site whose task wants a team. Value: seconds to wait for it, 1..1023
  DHTF_CLOSED = 2    // in a site, but there is no task for you. Value: wall sectors
};

enum { DHTF_SLOT = 0 };

#endif
