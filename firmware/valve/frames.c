// Frames of FVB/1: finding them in the bytes, their CRC, the replies.
#include "firmware/valve/frames.h"

#include "firmware/common/crc16.h"

enum { FIRST = 0xA5, SECOND = 0x5A, HEAD = 6, TAIL = 2 };

uint16_t valve_u16(const uint8_t* p) { return (uint16_t)(p[0] | (uint16_t)((uint16_t)p[1] << 8)); }

uint32_t valve_u32(const uint8_t* p) { return valve_u16(p) | ((uint32_t)valve_u16(p + 2) << 16); }

static uint16_t crc_of(const uint8_t* bytes, uint16_t size) {
  uint16_t crc = CRC16_BEGIN;
  for (uint16_t n = 0; n < size; ++n) crc = crc16_ccitt(crc, bytes[n]);
  return crc;
}

uint16_t valve_find_frame(const uint8_t* bytes, uint16_t size, struct frame* found) {
  found->good = false;
  uint16_t noise = 0;
  while (noise < size && bytes[noise] != FIRST) ++noise;
  if (noise > 0 || size < 2) return noise;
  if (bytes[1] != SECOND) return 1;
  if (size < HEAD) return 0;
  const uint16_t length = valve_u16(bytes + 4);
  if (length > VALVE_MAX_PAYLOAD) return 1;
  const uint16_t whole = (uint16_t)(HEAD + length + TAIL);
  if (size < whole) return 0;
  if (crc_of(bytes + 2, (uint16_t)(HEAD - 2 + length)) != valve_u16(bytes + HEAD + length)) return 1;
  found->good = true;
  found->type = bytes[2];
  found->number = bytes[3];
  found->payload = bytes + HEAD;
  found->length = length;
  return whole;
}

void valve_reply_begin(uint8_t* out, uint8_t* size, uint8_t type, uint8_t number) {
  out[0] = FIRST;
  out[1] = SECOND;
  out[2] = type;
  out[3] = number;
  out[4] = 0;
  out[5] = 0;
  *size = HEAD;
}

void valve_reply_add(uint8_t* out, uint8_t* size, uint32_t value, uint8_t bytes) {
  for (uint8_t n = 0; n < bytes && *size < VALVE_MAX_REPLY - TAIL; ++n) {
    out[*size] = (uint8_t)value;
    value >>= 8;
    ++*size;
  }
  out[4] = (uint8_t)(*size - HEAD);
}

void valve_reply_end(uint8_t* out, uint8_t* size) {
  const uint16_t crc = crc_of(out + 2, (uint16_t)(*size - 2));
  out[*size] = (uint8_t)crc;
  out[*size + 1] = (uint8_t)(crc >> 8);
  *size = (uint8_t)(*size + TAIL);
}
