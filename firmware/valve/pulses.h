// valve_start and valve_end begin and end the firing of a list. The tick interrupt must not come between.
#ifndef FIRN_FIRMWARE_PULSES_H
#define FIRN_FIRMWARE_PULSES_H

#include "firmware/valve/valve.h"

#ifdef __cplusplus
extern "C" {
#endif

void valve_start(struct valve* v);
void valve_end(struct valve* v, uint8_t why, uint8_t state);

#ifdef __cplusplus
}
#endif

#endif
