/* Style: functions and variables that are called like those of the C library and the system. Green when they are its own. */
#include <kilolib.h>

int sent = 0;
int clock = 7, signal = 3, optarg = 9, environ = 1, stdin_count = 0;
message_t m;

void send(int n) { sent += n; }
int sync() { return 11; }
int read(int x) { return x + 1; }
int write(int x) { return x + 2; }
int open(int x) { return x + 3; }
void close() { sent++; }
long time(int t) { return t * 2; }
int index(int i) { return i; }
void pause() { set_motors(0, 0); }
int kill(int who) { return who; }
void sleep(int s) { delay(s * 1000); }
int connect(int a, int b) { return a + b; }
void init() {}
void start() {}
int select(int best) { return best; }
int remove(int i) { return -i; }

void setup() {
    send(2);
    close();
    init();
    start();
}

void loop() {
    int good = sent == 3 && sync() == 11 && read(1) == 2 && write(1) == 3 && open(1) == 4 && time(21) == 42 && index(5) == 5 &&
               kill(8) == 8 && connect(1, 2) == 3 && clock == 7 && signal == 3 && optarg == 9 && environ == 1 && select(4) == 4 && remove(1) == -1;
    set_color(good ? RGB(0, 3, 0) : RGB(3, 0, 0));
    sleep(1);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
