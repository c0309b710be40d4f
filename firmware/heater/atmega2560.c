// The port of the heaters' firmware to an ATmega2560 at 16 MHz: UART0 at 9600 baud, three MAX31855 by SPI,
// three relays, the set points in EEPROM.
//
//   PE0, PE1       RXD0, TXD0
//   PB1, PB3       SCK, MISO of the converters
//   PA0, PA1, PA2  their chip selects, low while one is read: channels 1, 2, 3
//   PC0, PC1, PC2  relays of channels 1, 2, 3: high is on; pull-downs of 10 kOhm keep them off through a
//   reset
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>

#include "firmware/common/atmega2560.h"
#include "firmware/common/crc16.h"
#include "firmware/heater/heater.h"

enum {
  BAUD = 9600,
  TICK_MS = 25,
  TICKS = HEATER_TICK_MS / TICK_MS,
  ALL = (1 << HEATER_CHANNELS) - 1,
  SELECT_PIN = 1 << PB0,  // SPI's own: an output, or it ends the master's role
  CLOCK_PIN = 1 << PB1
};

static struct heater box;
static volatile uint8_t ticks;

struct kept {
  int32_t set_cdegC[HEATER_CHANNELS];
  uint16_t crc;
};
static struct kept EEMEM kept_set;

ISR(TIMER1_COMPA_vect) {
  if (ticks < 0xFFU) ++ticks;
}

static uint16_t crc_of(const struct kept* k) {
  const uint8_t* bytes = (const uint8_t*)k;
  uint16_t crc = CRC16_BEGIN;
  for (uint8_t n = 0; n < sizeof k->set_cdegC; ++n) crc = crc16_ccitt(crc, bytes[n]);
  return crc;
}

// The heat goes on after a reset: freezing destroys the valves.
static void restore(void) {
  struct kept k;
  eeprom_read_block(&k, &kept_set, sizeof k);
  if (crc_of(&k) != k.crc) return;
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n) (void)heater_restore(&box, n, k.set_cdegC[n]);
}

static void keep(void) {
  struct kept k;
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n) k.set_cdegC[n] = box.channel[n].set_cdegC;
  k.crc = crc_of(&k);
  eeprom_update_block(&k, &kept_set, sizeof k);  // 14 bytes at most, 3.3 ms each
  box.changed = false;
}

static uint32_t convert(uint8_t channel) {
  uint32_t word = 0;
  PORTA = (uint8_t)(ALL & ~(1U << channel));
  for (uint8_t n = 0; n < 4; ++n) {
    SPDR = 0;
    while ((SPSR & (1 << SPIF)) == 0) {
    }
    word = (word << 8) | SPDR;
  }
  PORTA = ALL;
  return word;
}

static void tick(void) {
  uint8_t relays = 0;
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n) heater_read(&box, n, convert(n));
  heater_tick(&box);
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n)
    if (box.channel[n].relay) relays = (uint8_t)(relays | (1U << n));
  PORTC = relays;
}

int main(void) {
  PORTC = 0;
  DDRC = ALL;
  PORTA = ALL;
  DDRA = ALL;
  DDRB = SELECT_PIN | CLOCK_PIN;
  SPCR = (1 << SPE) | (1 << MSTR) | (1 << SPR0);  // 1 MHz, mode 0
  heater_init(&box, HEATER_HIGHEST_CDEGC);
  restore();
  mcu_begin(BAUD, TICK_MS * 1000U);
  for (;;) {
    uint8_t byte;
    if (mcu_take(&byte)) {
      heater_receive(&box, byte);
      mcu_send(box.reply, box.reply_size);
      if (box.changed) keep();
    }
    mcu_lock();
    const uint8_t now = ticks;
    if (now >= TICKS) ticks = 0;
    mcu_unlock();
    if (now >= TICKS) tick();
  }
}
