// Thermocouples and relays.
#include "firmware/heater/heater.h"

void heater_init(struct heater* h, int32_t highest_cdegC) {
  h->highest_cdegC = highest_cdegC;
  h->changed = false;
  h->line_size = 0;
  h->reply_size = 0;
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n) {
    struct heater_channel* c = &h->channel[n];
    c->set_cdegC = HEATER_OFF_CDEGC;
    c->shown_cdegC = 0;
    c->ticks_since_reading = 0;
    c->open = true;
    c->cut_out = false;
    c->relay = false;
  }
}

bool heater_restore(struct heater* h, uint8_t channel, int32_t set_cdegC) {
  if (channel >= HEATER_CHANNELS || set_cdegC < HEATER_OFF_CDEGC || set_cdegC > h->highest_cdegC)
    return false;
  h->channel[channel].set_cdegC = set_cdegC;
  return true;
}

// Between the thresholds a relay stays as it is.
static void control(const struct heater* h, struct heater_channel* c) {
  if (!c->open && c->shown_cdegC > h->highest_cdegC + HEATER_CUT_OUT_CDEGC) c->cut_out = true;
  if (c->open || c->cut_out || c->set_cdegC == HEATER_OFF_CDEGC ||
      c->shown_cdegC >= c->set_cdegC + HEATER_HYSTERESIS_CDEGC)
    c->relay = false;
  else if (c->shown_cdegC <= c->set_cdegC - HEATER_HYSTERESIS_CDEGC)
    c->relay = true;
}

// MAX31855: bits 31 to 18 are the temperature in 0.25 degC, bit 16 says that the thermocouple has a fault,
// bits 17 and 3 are always 0: a converter that is missing leaves ones on the line.
void heater_read(struct heater* h, uint8_t channel, uint32_t word) {
  enum { QUARTER_CDEGC = 25, SIGN = 0x2000, SPAN = 0x4000 };
  static const uint32_t k_fault = 0x10000U, k_always_0 = 0x20008U;
  if (channel >= HEATER_CHANNELS) return;
  struct heater_channel* c = &h->channel[channel];
  const uint16_t quarters = (uint16_t)(word >> 18);
  const int32_t cdegC = ((int32_t)quarters - ((quarters & SIGN) != 0 ? SPAN : 0)) * QUARTER_CDEGC;
  c->ticks_since_reading = 0;
  c->open = (word & (k_fault | k_always_0)) != 0 || cdegC < HEATER_LOWEST_READ_CDEGC ||
            cdegC > HEATER_HIGHEST_READ_CDEGC;
  if (!c->open) c->shown_cdegC = cdegC;
}

void heater_tick(struct heater* h) {
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n) {
    struct heater_channel* c = &h->channel[n];
    if (c->ticks_since_reading < HEATER_STALE_TICKS)
      ++c->ticks_since_reading;
    else
      c->open = true;
    control(h, c);
  }
}
