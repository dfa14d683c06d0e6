/* Gradient in the style of people who write for another simulator too: all of a robot's variables in one structure behind a pointer, a
   ring buffer of its own, ageing of what was heard. */
#include <kilombo.h>
#include <stdio.h>
#ifdef SIMULATOR
#error "the robot's branch is wanted"
#endif
#define RB_SIZE 8
typedef struct { message_t msg; distance_measurement_t dist; } received_message_t;
typedef struct {
    uint8_t gradient_value, received, dist;
    uint32_t last_reception_time;
    message_t transmit_msg;
    char message_lock;
    received_message_t RXBuffer[RB_SIZE];
    uint8_t RXHead, RXTail;
} USERDATA;
REGISTER_USERDATA(USERDATA)
#define RB_full() ((mydata->RXHead + 1) % RB_SIZE == mydata->RXTail)
#define RB_empty() (mydata->RXHead == mydata->RXTail)
#define RB_back() mydata->RXBuffer[mydata->RXHead]
#define RB_front() mydata->RXBuffer[mydata->RXTail]
#define RB_pushback() do { mydata->RXHead = (mydata->RXHead + 1) % RB_SIZE; if (RB_empty()) mydata->RXTail = (mydata->RXTail + 1) % RB_SIZE; } while (0)
#define RB_popfront() do { mydata->RXTail = (mydata->RXTail + 1) % RB_SIZE; } while (0)
#define UNSET 255

void rxbuffer_push(message_t *msg, distance_measurement_t *dist) {
    received_message_t *rmsg = &RB_back();
    rmsg->msg = *msg;
    rmsg->dist = *dist;
    RB_pushback();
}
message_t *message_tx() { return mydata->gradient_value != UNSET && !mydata->message_lock ? &mydata->transmit_msg : 0; }

void setup_message(void) {
    mydata->message_lock = 1;
    mydata->transmit_msg.type = NORMAL;
    mydata->transmit_msg.data[0] = kilo_uid & 0xff;
    mydata->transmit_msg.data[2] = mydata->gradient_value;
    mydata->transmit_msg.crc = message_crc(&mydata->transmit_msg);
    mydata->message_lock = 0;
}
void setup() {
    mydata->gradient_value = kilo_uid == 0 ? 0 : UNSET;
    setup_message();
}
void process_message() {
    uint8_t *data = RB_front().msg.data;
    uint8_t value = data[2] + 1, distance = estimate_distance(&RB_front().dist);
    if (distance > 120) return;
    if (kilo_uid != 0 && value <= mydata->gradient_value) {
        mydata->gradient_value = value;
        mydata->last_reception_time = kilo_ticks;
    }
}
static const uint8_t colors[] = { RGB(3,3,3), RGB(3,0,0), RGB(3,3,0), RGB(0,3,0), RGB(0,3,3), RGB(0,0,3), RGB(3,0,3) };
void loop() {
    while (!RB_empty()) { process_message(); RB_popfront(); }
    if (kilo_uid != 0 && kilo_ticks > mydata->last_reception_time + 2 * 32) mydata->gradient_value = UNSET;
    setup_message();
    set_color(mydata->gradient_value == UNSET ? RGB(0,0,0) : colors[mydata->gradient_value % 7]);
}
#ifdef SIMULATOR
char *botinfo(void) { return "none"; }
#endif
int main() {
    kilo_init();
    kilo_message_rx = rxbuffer_push;
    kilo_message_tx = message_tx;
    SET_CALLBACK(botinfo, botinfo);
    kilo_start(setup, loop);
    return 0;
}
