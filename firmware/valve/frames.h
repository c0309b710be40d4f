// frame is a request of FVB/1 in the bytes of the serial line: `A5 5A | type | number | length u16 | payload
// | CRC-16/CCITT-FALSE u16`, little endian, the CRC over type .. payload.
#ifndef FIRN_FIRMWARE_FRAMES_H
#define FIRN_FIRMWARE_FRAMES_H

#include "firmware/valve/valve.h"

struct frame {
  bool good;
  uint8_t type, number;
  const uint8_t* payload;
  uint16_t length;
};

// Returns how many bytes of the begin to drop: a frame (found->good), or noise; 0: more have to come. Of a
// damaged frame one byte is noise, so that a frame within it is found.
uint16_t valve_find_frame(const uint8_t* bytes, uint16_t size, struct frame* found);

uint16_t valve_u16(const uint8_t* p);
uint32_t valve_u32(const uint8_t* p);

// A reply of at most VALVE_MAX_REPLY bytes: begin, add fields, end.
void valve_reply_begin(uint8_t* out, uint8_t* size, uint8_t type, uint8_t number);
void valve_reply_add(uint8_t* out, uint8_t* size, uint32_t value, uint8_t bytes);
void valve_reply_end(uint8_t* out, uint8_t* size);

#endif
