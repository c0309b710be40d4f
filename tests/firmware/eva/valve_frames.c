// Any bytes in the valve's buffer, any number of them: scripts/prove_firmware.py shows that the parser of frames reads
// nothing outside, and that a frame lies within its limits.
#include "__fc_builtin.h"

#include "firmware/valve/frames.h"

enum { ROOM = VALVE_MAX_PAYLOAD + 8 };
static uint8_t bytes[ROOM];

int main(void) {
  Frama_C_make_unknown((char*)bytes, sizeof bytes);
  const uint16_t size = (uint16_t)Frama_C_interval(0, ROOM);
  struct frame found = {0};
  const uint16_t taken = valve_find_frame(bytes, size, &found);
  //@ assert taken <= ROOM;
  //@ assert found.length <= VALVE_MAX_PAYLOAD;
  if (found.payload != 0 && found.length > 0) return found.payload[found.length - 1];
  return 0;
}
