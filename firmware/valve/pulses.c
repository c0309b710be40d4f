// Pulses of the list that fires, for the tick interrupt.
#include "firmware/valve/pulses.h"

enum {
  STEPS_OF_EXCESS = 40000,  // 2 s of open time
  HEAT_OPEN = 100 - VALVE_MAX_DUTY_PERCENT,
  HEAT_CLOSED = VALVE_MAX_DUTY_PERCENT
};
static const int32_t k_most_heat = (int32_t)STEPS_OF_EXCESS * HEAT_OPEN;

void valve_end(struct valve* v, uint8_t why, uint8_t state) {
  v->output = VALVE_CLOSED;
  v->open_us = 0;
  v->end = why;
  v->state = state;
}

static void aim(struct valve* v) {
  const uint16_t tick = v->spits ? v->fired : v->ticks[v->fired < VALVE_MAX_ENTRIES ? v->fired : 0];
  v->next_us = (uint32_t)tick * v->tick_us;
}

void valve_start(struct valve* v) {
  v->state = VALVE_FIRING;
  v->end = VALVE_NOT_ENDED;
  v->fired = 0;
  v->late_us = 0;
  v->since_us = 0;
  v->open_us = 0;
  v->wait_steps = 0;
  v->heard_steps = 0;
  if (v->entries > 0) aim(v);
}

// The outputs of this step: a pulse that is open, or the next one if its time has come.
static void pulse(struct valve* v) {
  if (v->output != VALVE_CLOSED) {
    v->open_us = (uint16_t)(v->open_us + VALVE_STEP_US);
    if (v->open_us >= v->pulse_us) {
      v->output = VALVE_CLOSED;
      v->open_us = 0;
    } else if (v->open_us >= VALVE_SPIKE_US) {
      v->output = VALVE_HOLD;
    }
  }
  if (v->output != VALVE_CLOSED) return;
  if (v->fired >= v->entries) {
    valve_end(v, VALVE_THROUGH, VALVE_DONE);
  } else if (v->since_us + VALVE_STEP_US / 2 >= v->next_us) {  // the step nearest to its time
    const uint32_t late = v->since_us > v->next_us ? v->since_us - v->next_us : 0;
    if (late > v->late_us) v->late_us = late > 0xFFFFU ? 0xFFFFU : (uint16_t)late;
    v->output = VALVE_SPIKE;
    v->open_us = 0;
    ++v->fired;
    if (v->fired < v->entries) aim(v);
  }
}

void valve_step(struct valve* v) {
  if (v->quiet_steps < 0xFFFFU) ++v->quiet_steps;
  if (v->heard_steps < 0xFFFFFFFFU) ++v->heard_steps;
  if (v->state == VALVE_FIRING) {
    pulse(v);
    v->since_us += VALVE_STEP_US;
    if (v->state == VALVE_FIRING && v->heard_steps >= v->silence_steps)
      valve_end(v, VALVE_WATCHDOG, VALVE_FAULT);
  } else if (v->state == VALVE_DONE) {
    if (v->since_us < 0xFFFFFFFFU - VALVE_STEP_US) v->since_us += VALVE_STEP_US;
  } else if (v->state == VALVE_ARMED && v->wait_steps > 0) {
    --v->wait_steps;
    if (v->wait_steps == 0) v->state = VALVE_LOADED;
  }
  // The coil's heat, whatever has opened it.
  if (v->output != VALVE_CLOSED) {
    v->heat += HEAT_OPEN;
    if (v->heat >= k_most_heat) valve_end(v, VALVE_TOO_HOT, VALVE_FAULT);
  } else if (v->heat > HEAT_CLOSED) {
    v->heat -= HEAT_CLOSED;
  } else {
    v->heat = 0;
  }
}

void valve_trigger(struct valve* v) {
  valve_lock();
  if (v->state == VALVE_ARMED) valve_start(v);
  valve_unlock();
}

void valve_disable(struct valve* v) {
  valve_lock();
  if (v->state == VALVE_FIRING) valve_end(v, VALVE_DISABLED, VALVE_DONE);
  valve_unlock();
}
