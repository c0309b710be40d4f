// Requests of FVB/1.
#include "firmware/valve/valve.h"

#include "firmware/common/crc16.h"
#include "firmware/valve/frames.h"
#include "firmware/valve/pulses.h"

enum {
  HELLO = 0x01,
  BEGIN = 0x02,
  DATA = 0x03,
  END = 0x04,
  ARM = 0x05,
  DISARM = 0x06,
  STATUS = 0x07,
  ABORT = 0x08,
  SPIT = 0x09,
  ACK = 0x7E,
  NAK = 0x7F
};

enum { NONE = 0, BAD_NUMBER = 11, BAD_STATE = 20, BAD_RANGE = 21, BAD_ORDER = 22, MISMATCH = 23 };

enum {
  PAUSE_STEPS = 1000,     // 50 ms
  SILENCE_STEPS = 40000,  // 2 s
  HEAD_BYTES = 11,        // of BEGIN and SPIT
  STEPS_OF_A_MS = 1000 / VALVE_STEP_US
};
static const uint32_t k_longest_wait_ms = 100000000;  // 27 hours: 2e9 steps fit into 32 bits

void valve_init(struct valve* v, uint16_t boots, uint8_t reset_cause) {
  v->boots = boots;
  v->reset_cause = reset_cause;
  v->pause_steps = PAUSE_STEPS;
  v->silence_steps = SILENCE_STEPS;
  v->frame_size = 0;
  v->quiet_steps = 0;
  v->reply_size = 0;
  v->answer_size = 0;
  v->last_number = 0;
  v->known = false;
  v->held = 0;
  v->path = 0;
  v->entries = 0;
  v->tick_us = 0;
  v->pulse_us = 0;
  v->spits = false;
  v->state = VALVE_IDLE;
  v->end = VALVE_NOT_ENDED;
  v->output = VALVE_CLOSED;
  v->fired = 0;
  v->late_us = 0;
  v->since_us = 0;
  v->next_us = 0;
  v->open_us = 0;
  v->wait_steps = 0;
  v->heard_steps = 0;
  v->heat = 0;
}

static bool busy(const struct valve* v) { return v->state == VALVE_FIRING || v->state == VALVE_ARMED; }

static void take_head(struct valve* v, const uint8_t* p) {
  v->path = valve_u32(p);
  v->entries = valve_u16(p + 5);
  v->tick_us = valve_u16(p + 7);
  v->pulse_us = valve_u16(p + 9);
  v->fired = 0;
  v->held = 0;
}

static bool pulse_is_good(uint16_t pulse_us) {
  return pulse_us >= VALVE_MIN_PULSE_US && pulse_us <= VALVE_MAX_PULSE_US;
}

static uint8_t begin(struct valve* v, const struct frame* f) {
  if (busy(v)) return BAD_STATE;
  if (f->length != HEAD_BYTES) return BAD_RANGE;
  if (valve_u16(f->payload + 5) > VALVE_MAX_ENTRIES || valve_u16(f->payload + 7) == 0 ||
      !pulse_is_good(valve_u16(f->payload + 9)))
    return BAD_RANGE;
  valve_lock();
  take_head(v, f->payload);
  v->spits = false;
  v->state = VALVE_LOADING;
  valve_unlock();
  return NONE;
}

static uint8_t spit(struct valve* v, const struct frame* f) {
  if (busy(v)) return BAD_STATE;
  if (f->length != HEAD_BYTES) return BAD_RANGE;
  const uint16_t entries = valve_u16(f->payload + 5), tick_us = valve_u16(f->payload + 7),
                 pulse_us = valve_u16(f->payload + 9);
  if (entries == 0 || !pulse_is_good(pulse_us) || tick_us < (uint32_t)pulse_us + VALVE_GUARD_US)
    return BAD_RANGE;
  valve_lock();
  take_head(v, f->payload);
  v->spits = true;
  valve_start(v);
  valve_unlock();
  return NONE;
}

// Entries held beyond the offset are forgotten; good ones before a bad entry are kept.
static uint8_t add(struct valve* v, const struct frame* f) {
  if (v->state != VALVE_LOADING) return BAD_STATE;
  if (f->length < 4 || (f->length & 1U) != 0) return BAD_RANGE;
  const uint16_t offset = valve_u16(f->payload), count = (uint16_t)(f->length / 2 - 1);
  if (offset > v->held) return BAD_ORDER;
  if ((uint32_t)offset + count > v->entries) return BAD_RANGE;
  v->held = offset;
  for (uint16_t n = 0; n < count; ++n) {
    const uint16_t tick = valve_u16(f->payload + 2 + 2 * n);
    if (v->held > 0) {
      const uint16_t last = v->ticks[v->held - 1];
      if (tick <= last || (uint32_t)(tick - last) * v->tick_us < (uint32_t)v->pulse_us + VALVE_GUARD_US)
        return BAD_ORDER;
    }
    v->ticks[v->held] = tick;
    ++v->held;
  }
  return NONE;
}

static uint8_t verify(struct valve* v, const struct frame* f) {
  if (v->state != VALVE_LOADING) return BAD_STATE;
  if (v->held != v->entries || f->length != 2) return MISMATCH;
  uint16_t crc = CRC16_BEGIN;
  for (uint16_t n = 0; n < v->held; ++n) {
    crc = crc16_ccitt(crc, (uint8_t)v->ticks[n]);
    crc = crc16_ccitt(crc, (uint8_t)(v->ticks[n] >> 8));
  }
  if (crc != valve_u16(f->payload)) return MISMATCH;
  v->state = VALVE_LOADED;
  return NONE;
}

static uint8_t arm(struct valve* v, const struct frame* f) {
  if (v->state != VALVE_LOADED) return BAD_STATE;
  if (f->length != 4) return BAD_RANGE;
  uint32_t wait_ms = valve_u32(f->payload);
  if (wait_ms > k_longest_wait_ms) wait_ms = k_longest_wait_ms;
  valve_lock();
  v->wait_steps = wait_ms * STEPS_OF_A_MS;
  v->state = VALVE_ARMED;
  valve_unlock();
  return NONE;
}

static uint8_t disarm(struct valve* v) {
  if (v->state == VALVE_FAULT) return BAD_STATE;
  valve_lock();
  if (v->state == VALVE_FIRING)
    valve_end(v, VALVE_DISARMED, VALVE_DONE);
  else if (v->state == VALVE_ARMED)
    v->state = VALVE_LOADED;
  v->wait_steps = 0;
  valve_unlock();
  return NONE;
}

static uint8_t stop(struct valve* v) {
  valve_lock();
  if (v->state == VALVE_FIRING) valve_end(v, VALVE_ABORTED, VALVE_IDLE);
  v->output = VALVE_CLOSED;
  v->state = VALVE_IDLE;
  v->wait_steps = 0;
  v->held = 0;
  valve_unlock();
  return NONE;
}

static uint8_t obey(struct valve* v, const struct frame* f) {
  switch (f->type) {
    case BEGIN:
      return begin(v, f);
    case DATA:
      return add(v, f);
    case END:
      return verify(v, f);
    case ARM:
      return arm(v, f);
    case DISARM:
      return disarm(v);
    case ABORT:
      return stop(v);
    case SPIT:
      return spit(v, f);
    default:
      return BAD_RANGE;
  }
}

static void refuse(struct valve* v, uint8_t number, uint8_t why) {
  valve_reply_begin(v->reply, &v->reply_size, NAK, number);
  valve_reply_add(v->reply, &v->reply_size, v->boots, 2);
  valve_reply_add(v->reply, &v->reply_size, why, 1);
  valve_reply_end(v->reply, &v->reply_size);
}

static void greet(struct valve* v, uint8_t number) {
  valve_reply_begin(v->reply, &v->reply_size, HELLO, number);
  valve_reply_add(v->reply, &v->reply_size, v->boots, 2);
  valve_reply_add(v->reply, &v->reply_size, VALVE_FIRMWARE, 2);
  valve_reply_add(v->reply, &v->reply_size, v->reset_cause, 1);
  valve_reply_add(v->reply, &v->reply_size, VALVE_MAX_ENTRIES, 2);
  valve_reply_add(v->reply, &v->reply_size, VALVE_STEP_US, 2);
  valve_reply_add(v->reply, &v->reply_size, VALVE_MAX_PULSE_US, 2);
  valve_reply_add(v->reply, &v->reply_size, VALVE_MAX_DUTY_PERCENT, 1);
  valve_reply_end(v->reply, &v->reply_size);
}

static void report(struct valve* v, uint8_t number) {
  valve_lock();
  const uint8_t state = v->state;
  const uint16_t fired = v->fired, late_us = v->late_us;
  const uint32_t since_us = v->since_us;
  valve_unlock();
  const bool fires = state == VALVE_FIRING || state == VALVE_DONE;
  valve_reply_begin(v->reply, &v->reply_size, STATUS, number);
  valve_reply_add(v->reply, &v->reply_size, v->boots, 2);
  valve_reply_add(v->reply, &v->reply_size, state, 1);
  valve_reply_add(v->reply, &v->reply_size, v->path, 4);
  valve_reply_add(v->reply, &v->reply_size, fired, 2);
  valve_reply_add(v->reply, &v->reply_size, fires ? since_us : 0, 4);
  valve_reply_add(v->reply, &v->reply_size, fires ? late_us : 0, 2);
  valve_reply_end(v->reply, &v->reply_size);
}

static bool is_newer(uint8_t number, uint8_t last) {
  const uint8_t ahead = number > last ? (uint8_t)(number - last) : (uint8_t)(number - last + 255);
  return number != 0 && number != last && ahead <= 127;
}

static void keep_answer(struct valve* v) {
  for (uint8_t n = 0; n < VALVE_MAX_REPLY; ++n) v->answer[n] = v->reply[n];
  v->answer_size = v->reply_size;
}

static void repeat_answer(struct valve* v) {
  for (uint8_t n = 0; n < VALVE_MAX_REPLY; ++n) v->reply[n] = v->answer[n];
  v->reply_size = v->answer_size;
}

static void execute(struct valve* v, const struct frame* f) {
  valve_lock();
  v->heard_steps = 0;
  valve_unlock();
  if (f->type != HELLO && v->known) {
    if (f->number == v->last_number) {
      repeat_answer(v);
      return;
    }
    if (!is_newer(f->number, v->last_number)) {
      refuse(v, f->number, BAD_NUMBER);
      return;
    }
  }
  if (f->type == HELLO) {
    greet(v, f->number);
  } else if (f->type == STATUS) {
    report(v, f->number);
  } else {
    const uint8_t why = obey(v, f);
    if (why == NONE) {
      valve_reply_begin(v->reply, &v->reply_size, ACK, f->number);
      valve_reply_add(v->reply, &v->reply_size, v->boots, 2);
      valve_reply_end(v->reply, &v->reply_size);
    } else {
      refuse(v, f->number, why);
    }
  }
  v->last_number = f->number;
  v->known = true;
  keep_answer(v);
}

static void drop(struct valve* v, uint16_t count) {
  for (uint16_t n = count; n < v->frame_size; ++n) v->frame[n - count] = v->frame[n];
  v->frame_size = (uint16_t)(v->frame_size - count);
}

void valve_receive(struct valve* v, uint8_t byte) {
  valve_lock();
  const uint16_t quiet = v->quiet_steps;
  v->quiet_steps = 0;
  valve_unlock();
  v->reply_size = 0;
  if (quiet > v->pause_steps) v->frame_size = 0;
  v->frame[v->frame_size] = byte;
  ++v->frame_size;
  // Each turn drops at least one byte. Of two frames that end with this byte only one can be good.
  for (uint16_t turn = 0; turn < VALVE_MAX_FRAME; ++turn) {
    struct frame found;
    const uint16_t size = valve_find_frame(v->frame, v->frame_size, &found);
    if (size == 0) break;
    if (found.good) execute(v, &found);
    drop(v, size);
  }
}
