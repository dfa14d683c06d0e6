#ifndef SHOWN
#error "give SHOWN"
#endif
#define COLOUR RGB(0, SHOWN, 0)
