// Parts that each box with an ATmega2560 at 16 MHz has: the serial line UART0, the tick of timer 1, the
// watchdog, the cause of the reset, a lock against interrupts.
#ifndef FIRN_FIRMWARE_ATMEGA2560_H
#define FIRN_FIRMWARE_ATMEGA2560_H

#include <stdbool.h>
#include <stdint.h>

enum { MCU_HZ = 16000000, MCU_TIMER_HZ = MCU_HZ / 8 };

// 0 power, 1 watchdog, 2 pin, 3 brown-out.
uint8_t mcu_reset_cause(void);

// Starts the line, the watchdog of 0.5 s and the interrupt TIMER1_COMPA every `tick_us` (at most 32768). The
// pins must be set before.
void mcu_begin(uint32_t baud, uint16_t tick_us);

// Serves the watchdog. Takes the next byte of the line; where none has come it sleeps until an interrupt and
// returns false.
bool mcu_take(uint8_t* byte);
void mcu_send(const uint8_t* bytes, uint8_t count);

// No interrupt between the two. They do not nest.
void mcu_lock(void);
void mcu_unlock(void);

#endif
