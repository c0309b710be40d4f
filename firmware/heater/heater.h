// heater is the firmware of the heaters' box: three thermocouples behind MAX31855 converters, three ON/OFF
// controllers that drive relays, and the lines of docs/devices/heater.md. Freestanding C11 without memory
// from a heap, without recursion, with bounded loops. It knows no hardware: a port hands it bytes, words of
// the converters and ticks, and drives its relays.
#ifndef FIRN_FIRMWARE_HEATER_H
#define FIRN_FIRMWARE_HEATER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// The highest set point: 45 degC of an end effector; a platen's box is built with another.
#ifndef HEATER_HIGHEST_CDEGC
#define HEATER_HIGHEST_CDEGC 4500
#endif

enum {
  HEATER_CHANNELS = 3,
  HEATER_TICK_MS = 100,           // a MAX31855 converts in 70 to 100 ms
  HEATER_OFF_CDEGC = -5000,       // set point, 0.01 degC: off
  HEATER_HYSTERESIS_CDEGC = 100,  // on at set - this, off at set + this
  HEATER_CUT_OUT_CDEGC = 500,     // above the highest set point by so much: off until the next set point
  HEATER_LOWEST_READ_CDEGC = -10000,
  HEATER_HIGHEST_READ_CDEGC = 40000,  // outside: the thermocouple or its converter has failed
  HEATER_STALE_TICKS = 20,            // without a reading: as an open thermocouple
  HEATER_MAX_LINE = 64,
  HEATER_MAX_REPLY = 64
};

struct heater_channel {
  int32_t set_cdegC, shown_cdegC;
  uint8_t ticks_since_reading;
  bool open;     // no temperature is known
  bool cut_out;  // it was too hot
  bool relay;
};

struct heater {
  int32_t highest_cdegC;
  struct heater_channel channel[HEATER_CHANNELS];
  bool changed;  // a set point is new: the port keeps the set points over a loss of power
  uint8_t line[HEATER_MAX_LINE];
  uint8_t line_size;
  uint8_t reply[HEATER_MAX_REPLY];
  uint8_t reply_size;
};

// Starts with all set points off.
void heater_init(struct heater* h, int32_t highest_cdegC);
// Sets a kept set point. Returns false, and leaves the channel off, where it is none.
bool heater_restore(struct heater* h, uint8_t channel, int32_t set_cdegC);
// One byte of the serial line. Afterwards reply_size bytes of reply are to be sent, if any.
void heater_receive(struct heater* h, uint8_t byte);
// The 32 bits of a channel's MAX31855, channel from 0 on.
void heater_read(struct heater* h, uint8_t channel, uint32_t word);
// Every HEATER_TICK_MS; then the port sets its relays.
void heater_tick(struct heater* h);

#ifdef __cplusplus
}
#endif

#endif
