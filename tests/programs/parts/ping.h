/* For labs_ping_own_header.c. */
#ifndef PING_H
#define PING_H
#include <stdbool.h>
#include "kilolib.h"

enum { PING = 10, PONG };
typedef struct state {
    message_t msg;
    uint8_t pending;
    uint16_t count;
    bool heard;
} state_t;

inline void fill(message_t *m, uint8_t type, uint16_t who) {
    m->type = type;
    m->data[0] = who & 0xff;
    m->data[1] = who >> 8;
    m->crc = message_crc(m);
}
#endif
