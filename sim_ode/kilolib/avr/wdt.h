/* The robot's library does not use the watchdog timer; a program may feed it or switch it off, and is told when it
 * starts it. */
#ifndef ARKMESH_AVR_WDT_H
#define ARKMESH_AVR_WDT_H
enum { WDTO_15MS, WDTO_30MS, WDTO_60MS, WDTO_120MS, WDTO_250MS, WDTO_500MS, WDTO_1S, WDTO_2S, WDTO_4S, WDTO_8S };
#pragma GCC visibility push(hidden)
void arkmesh_gives_up(const char* why);
#pragma GCC visibility pop
#define wdt_reset() ((void)0)
#define wdt_disable() ((void)0)
#define wdt_enable(time) \
  ((void)(time), arkmesh_gives_up("called wdt_enable(), but a simulated robot has no watchdog timer"))
#endif
