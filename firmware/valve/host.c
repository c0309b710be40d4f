// The host's port: the simulated world calls the firmware's parts one after the other, no interrupt comes
// between.
#include "firmware/valve/valve.h"

void valve_lock(void) {}
void valve_unlock(void) {}
