/* Minimal naming game with a vocabulary kept as a linked list in a pool of its own; speaker and hearer keep only the word agreed on. */
#include <kilolib.h>
#include <stdlib.h>
#include <string.h>
#define POOL 12
typedef struct word { uint8_t name; struct word *next; } word_t;
static word_t pool[POOL], *free_list, *mine;
static message_t out;
static uint8_t has_heard, heard_word;
static uint32_t next_talk;
static void give(word_t *w) { w->next = free_list; free_list = w; }
static word_t *take(void) { word_t *w = free_list; if (w) free_list = w->next; return w; }
static word_t **find(uint8_t name) { word_t **p; for (p = &mine; *p; p = &(*p)->next) if ((*p)->name == name) return p; return NULL; }
static void keep_only(uint8_t name) { word_t *w = mine; while (w) { word_t *n = w->next; if (w->name != name) give(w); w = n; } w = NULL; for (uint8_t i = 0; i < POOL; i++) if (pool[i].name == name && name) w = &pool[i]; mine = w; if (w) w->next = NULL; }
static void learn(uint8_t name) { word_t *w = take(); if (!w) return; w->name = name; w->next = mine; mine = w; }
static uint8_t pick(void) { uint8_t n = 0, k; word_t *w; for (w = mine; w; w = w->next) n++; if (!n) { learn(1 + rand_soft() % 7); return mine ? mine->name : 1; } k = rand() % n; for (w = mine; k--; w = w->next) ; return w->name; }
static message_t *tx(void) { return out.data[0] ? &out : NULL; }
static void ok(void) { out.data[0] = 0; }
static void rx(message_t *m, distance_measurement_t *d) { if (!has_heard) { heard_word = m->data[0]; has_heard = 1; } }
static const uint8_t colour[8] = { 0, 3, 12, 48, 15, 51, 60, 63 };
void setup(void) { rand_seed(rand_hard()); srand(rand_hard() | kilo_uid << 8); for (uint8_t i = 0; i < POOL; i++) { memset(&pool[i], 0, sizeof pool[i]); give(&pool[i]); } }
void loop(void) {
    if (has_heard) {
        if (find(heard_word)) keep_only(heard_word); else learn(heard_word);
        has_heard = 0;
    }
    if (kilo_ticks > next_talk) { uint8_t w = pick(); out.type = NORMAL; out.data[0] = w; out.crc = message_crc(&out); next_talk = kilo_ticks + 32 + rand_soft() % 64; }
    set_color(mine && !mine->next ? colour[mine->name & 7] : 0);
}
int main(void) { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_message_tx_success = ok; kilo_start(setup, loop); return 0; }
