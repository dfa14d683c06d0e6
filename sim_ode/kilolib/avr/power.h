/* Power is not simulated. */
#ifndef ARKMESH_AVR_POWER_H
#define ARKMESH_AVR_POWER_H
#define power_all_enable() ((void)0)
#define power_all_disable() ((void)0)
#define power_adc_enable() ((void)0)
#define power_adc_disable() ((void)0)
#define power_timer0_enable() ((void)0)
#define power_timer1_enable() ((void)0)
#define power_timer2_enable() ((void)0)
#define power_spi_disable() ((void)0)
#define power_twi_disable() ((void)0)
#define power_usart0_enable() ((void)0)
#define power_usart0_disable() ((void)0)
#endif
