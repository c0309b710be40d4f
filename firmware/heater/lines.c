// Lines of the heaters' box: `<text>*<CRC4>` CR LF both ways.
#include "firmware/common/crc16.h"
#include "firmware/heater/heater.h"

enum { TAIL = 7, DIGITS = 4 };  // the star, four digits, CR LF
enum { DAMAGED = '1', UNKNOWN = '2', REFUSED = '3' };
static const uint8_t k_hex[] = "0123456789ABCDEF";

static uint16_t crc_of(const uint8_t* text, uint8_t size) {
  uint16_t crc = CRC16_BEGIN;
  for (uint8_t n = 0; n < size; ++n) crc = crc16_ccitt(crc, text[n]);
  return crc;
}

static void put(struct heater* h, uint8_t byte) {
  if (h->reply_size < HEATER_MAX_REPLY) {
    h->reply[h->reply_size] = byte;
    ++h->reply_size;
  }
}

static void put_number(struct heater* h, int32_t value) {
  uint8_t digits[10];
  uint8_t count = 0;
  uint32_t rest = value < 0 ? (uint32_t)-value : (uint32_t)value;
  do {
    digits[count] = (uint8_t)('0' + rest % 10U);
    rest /= 10U;
    ++count;
  } while (rest != 0 && count < sizeof digits);
  if (value < 0) put(h, '-');
  while (count > 0) {
    --count;
    put(h, digits[count]);
  }
}

static void seal(struct heater* h) {
  const uint16_t crc = crc_of(h->reply, h->reply_size);
  put(h, '*');
  for (uint8_t n = 0; n < DIGITS; ++n) put(h, k_hex[(crc >> (12 - 4 * n)) & 15U]);
  put(h, '\r');
  put(h, '\n');
}

static void refuse(struct heater* h, uint8_t why) {
  h->reply_size = 0;
  put(h, 'E');
  put(h, ',');
  put(h, why);
}

static void report(struct heater* h) {
  uint8_t relays = 0;
  put(h, 'T');
  for (uint8_t n = 0; n < HEATER_CHANNELS; ++n) {
    const struct heater_channel* c = &h->channel[n];
    put(h, ',');
    if (c->open) {
      put(h, 'O');
      put(h, 'P');
      put(h, 'E');
      put(h, 'N');
    } else {
      put_number(h, c->shown_cdegC);
    }
    if (c->relay) relays = (uint8_t)(relays | (1U << n));
  }
  put(h, ',');
  put_number(h, relays);
}

// Reads a whole number: a sign or none, digits. Returns false for all else. A number beyond `k_large` is it.
static bool number(const uint8_t* text, uint8_t size, int32_t* value) {
  static const int32_t k_large = 1000000;
  const bool negative = size > 0 && text[0] == '-';
  uint8_t at = size > 0 && (negative || text[0] == '+') ? 1 : 0;
  int32_t sum = 0;
  if (at >= size) return false;
  for (; at < size; ++at) {
    if (text[at] < '0' || text[at] > '9') return false;
    if (sum < k_large) sum = 10 * sum + (text[at] - '0');
  }
  *value = negative ? -sum : sum;
  return true;
}

static void set_point(struct heater* h, uint8_t size) {
  const uint8_t* text = h->line;
  uint8_t comma = 2;
  int32_t channel = 0, cdegC = 0;
  while (comma < size && text[comma] != ',') ++comma;
  if (comma >= size || !number(text + 2, (uint8_t)(comma - 2), &channel) ||
      !number(text + comma + 1, (uint8_t)(size - comma - 1), &cdegC) || channel < 1 ||
      channel > HEATER_CHANNELS || !heater_restore(h, (uint8_t)(channel - 1), cdegC)) {
    refuse(h, REFUSED);
    return;
  }
  h->channel[channel - 1].cut_out = false;
  h->changed = true;
  for (uint8_t n = 0; n < size; ++n) put(h, text[n]);
}

static void execute(struct heater* h) {
  const uint8_t* line = h->line;
  const uint8_t size = h->line_size < TAIL ? 0 : (uint8_t)(h->line_size - TAIL);
  const uint16_t crc = crc_of(line, size);
  bool whole = h->line_size >= TAIL && line[size] == '*' && line[size + 5] == '\r' && line[size + 6] == '\n';
  for (uint8_t n = 0; whole && n < DIGITS; ++n)
    whole = line[size + 1 + n] == k_hex[(crc >> (12 - 4 * n)) & 15U];
  if (!whole)
    refuse(h, DAMAGED);
  else if (size == 2 && line[0] == 'T' && line[1] == '?')
    report(h);
  else if (size >= 2 && line[0] == 'S' && line[1] == ',')
    set_point(h, size);
  else
    refuse(h, UNKNOWN);
  seal(h);
}

void heater_receive(struct heater* h, uint8_t byte) {
  h->reply_size = 0;
  if (h->line_size < HEATER_MAX_LINE) {
    h->line[h->line_size] = byte;
    ++h->line_size;
  }
  if (byte != '\n') return;
  execute(h);
  h->line_size = 0;
}
