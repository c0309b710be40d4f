// The port of the valve's firmware to an ATmega2560 at 16 MHz: UART0 at 115200 baud, timer 1 every 50 us, the
// robot's two lines, spike and hold outputs, the watchdog, the boot count in EEPROM.
//
//   PE0, PE1  RXD0, TXD0
//   PE4 INT4  the robot's signal (rises: trigger), by an opto-coupler
//   PE5 INT5  the robot's enable line (falls: closed), by an opto-coupler
//   PB6       24 V spike, PB7 3.5 V hold: to the drivers, with pull-downs of 10 kOhm that close the valve
//   through a reset
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "firmware/valve/valve.h"

enum {
  CPU_HZ = 16000000,
  BAUD = 115200,
  DIVIDER = (CPU_HZ / 4 / BAUD - 1) / 2,                 // double speed: 16 is 117,647 baud, 2.1 % fast
  TIMER_TOP = CPU_HZ / 8 / 1000000 * VALVE_STEP_US - 1,  // prescaler 8
  SPIKE_PIN = 1 << PB6,
  HOLD_PIN = 1 << PB7,
  RING = 256
};

static struct valve box;
static volatile uint8_t ring[RING];
static volatile uint8_t ring_in, ring_out;
static uint16_t EEMEM kept_boots;
static uint8_t saved_sreg;

// Before main: the reset's cause, and no watchdog until main starts its own.
static uint8_t cause_bits __attribute__((section(".noinit")));
void note_cause(void) __attribute__((naked, used, section(".init3")));
void note_cause(void) {
  cause_bits = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

void valve_lock(void) {
  const uint8_t sreg = SREG;
  cli();
  saved_sreg = sreg;
}

void valve_unlock(void) { SREG = saved_sreg; }

static void show(uint8_t output) {
  uint8_t pins = (uint8_t)(PORTB & (uint8_t) ~(SPIKE_PIN | HOLD_PIN));
  if (output != VALVE_CLOSED) pins |= HOLD_PIN;
  if (output == VALVE_SPIKE) pins |= SPIKE_PIN;
  PORTB = pins;
}

ISR(TIMER1_COMPA_vect) {
  valve_step(&box);
  show(box.output);
}

// A byte that finds the ring full is lost: its frame's CRC fails, and the host asks again.
ISR(USART0_RX_vect) {
  const uint8_t byte = UDR0;
  const uint8_t next = (uint8_t)(ring_in + 1);
  if (next != ring_out) {
    ring[ring_in] = byte;
    ring_in = next;
  }
}

ISR(INT4_vect) { valve_trigger(&box); }

ISR(INT5_vect) {
  valve_disable(&box);
  show(box.output);
}

static uint8_t cause(void) {
  if (cause_bits & (1 << WDRF)) return 1;
  if (cause_bits & (1 << BORF)) return 3;
  if (cause_bits & (1 << PORF)) return 0;
  return 2;
}

// The count goes round at 65535 without 0, which an erased EEPROM does not hold either.
static uint16_t count_boot(void) {
  uint16_t boots = eeprom_read_word(&kept_boots);
  boots = boots >= 0xFFFFU ? 1 : (uint16_t)(boots + 1);
  eeprom_update_word(&kept_boots, boots);
  return boots;
}

int main(void) {
  PORTB = 0;
  DDRB = SPIKE_PIN | HOLD_PIN;
  valve_init(&box, count_boot(), cause());
  UBRR0 = DIVIDER;
  UCSR0A = 1 << U2X0;
  UCSR0B = (1 << RXEN0) | (1 << TXEN0) | (1 << RXCIE0);
  UCSR0C = (1 << UCSZ01) | (1 << UCSZ00);
  TCCR1A = 0;
  TCCR1B = (1 << WGM12) | (1 << CS11);
  OCR1A = TIMER_TOP;
  TIMSK1 = 1 << OCIE1A;
  EICRB = (1 << ISC41) | (1 << ISC40) | (1 << ISC51);  // INT4 rising, INT5 falling
  EIMSK = (1 << INT4) | (1 << INT5);
  wdt_enable(WDTO_500MS);
  set_sleep_mode(SLEEP_MODE_IDLE);
  sei();
  for (;;) {
    wdt_reset();
    cli();
    if (ring_out == ring_in) {
      // The instruction after sei runs before any interrupt: no byte comes between the look and the sleep.
      sleep_enable();
      sei();
      sleep_cpu();
      sleep_disable();
      continue;
    }
    sei();
    const uint8_t byte = ring[ring_out];
    ring_out = (uint8_t)(ring_out + 1);
    valve_receive(&box, byte);
    for (uint8_t n = 0; n < box.reply_size; ++n) {
      while ((UCSR0A & (1 << UDRE0)) == 0) wdt_reset();
      UDR0 = box.reply[n];
    }
  }
}
