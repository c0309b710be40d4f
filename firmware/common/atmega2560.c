#include "firmware/common/atmega2560.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

enum { RING = 256 };

static volatile uint8_t ring[RING];
static volatile uint8_t ring_in, ring_out;
static uint8_t saved_sreg;

// Before main: the reset's cause, and no watchdog until main starts its own.
static uint8_t cause_bits __attribute__((section(".noinit")));
void note_cause(void) __attribute__((naked, used, section(".init3")));
void note_cause(void) {
  cause_bits = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

uint8_t mcu_reset_cause(void) {
  if (cause_bits & (1 << WDRF)) return 1;
  if (cause_bits & (1 << BORF)) return 3;
  if (cause_bits & (1 << PORF)) return 0;
  return 2;
}

void mcu_lock(void) {
  const uint8_t sreg = SREG;
  cli();
  saved_sreg = sreg;
}

void mcu_unlock(void) { SREG = saved_sreg; }

// A byte that finds the ring full is lost: the CRC of its frame or line fails, and the host asks again.
ISR(USART0_RX_vect) {
  const uint8_t byte = UDR0;
  const uint8_t next = (uint8_t)(ring_in + 1);
  if (next != ring_out) {
    ring[ring_in] = byte;
    ring_in = next;
  }
}

void mcu_begin(uint32_t baud, uint16_t tick_us) {
  UBRR0 = (uint16_t)((MCU_HZ / 4 / baud - 1) / 2);  // double speed; 115200 becomes 117,647 baud, 2.1 % fast
  UCSR0A = 1 << U2X0;
  UCSR0B = (1 << RXEN0) | (1 << TXEN0) | (1 << RXCIE0);
  UCSR0C = (1 << UCSZ01) | (1 << UCSZ00);
  TCCR1A = 0;
  TCCR1B = (1 << WGM12) | (1 << CS11);  // prescaler 8
  OCR1A = (uint16_t)((uint32_t)tick_us * (MCU_TIMER_HZ / 1000000) - 1);
  TIMSK1 = 1 << OCIE1A;
  wdt_enable(WDTO_500MS);
  set_sleep_mode(SLEEP_MODE_IDLE);
  sei();
}

bool mcu_take(uint8_t* byte) {
  wdt_reset();
  cli();
  if (ring_out == ring_in) {
    // The instruction after sei runs before any interrupt: no byte comes between the look and the sleep.
    sleep_enable();
    sei();
    sleep_cpu();
    sleep_disable();
    return false;
  }
  sei();
  *byte = ring[ring_out];
  ring_out = (uint8_t)(ring_out + 1);
  return true;
}

void mcu_send(const uint8_t* bytes, uint8_t count) {
  for (uint8_t n = 0; n < count; ++n) {
    while ((UCSR0A & (1 << UDRE0)) == 0) wdt_reset();
    UDR0 = bytes[n];
  }
}
