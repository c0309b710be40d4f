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

#include "firmware/common/atmega2560.h"
#include "firmware/valve/valve.h"

enum { SPIKE_PIN = 1 << PB6, HOLD_PIN = 1 << PB7 };
static const uint32_t k_baud = 115200;

static struct valve box;
static uint16_t EEMEM kept_boots;

void valve_lock(void) { mcu_lock(); }
void valve_unlock(void) { mcu_unlock(); }

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

ISR(INT4_vect) { valve_trigger(&box); }

ISR(INT5_vect) {
  valve_disable(&box);
  show(box.output);
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
  valve_init(&box, count_boot(), mcu_reset_cause());
  EICRB = (1 << ISC41) | (1 << ISC40) | (1 << ISC51);  // INT4 rising, INT5 falling
  EIMSK = (1 << INT4) | (1 << INT5);
  mcu_begin(k_baud, VALVE_STEP_US);
  for (;;) {
    uint8_t byte;
    if (!mcu_take(&byte)) continue;
    valve_receive(&box, byte);
    mcu_send(box.reply, box.reply_size);
  }
}
