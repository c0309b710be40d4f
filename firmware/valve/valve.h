// valve is the firmware of a valve's box: FVB/1 over a serial line, one list of pulse times, a spike-and-hold
// output (docs/devices/valve.md). Freestanding C11 without memory from a heap, without recursion, with
// bounded loops. It knows no hardware: a port hands it bytes and ticks and drives its outputs.
#ifndef FIRN_FIRMWARE_VALVE_H
#define FIRN_FIRMWARE_VALVE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// Entries of a list: two bytes each. An ATmega2560 has room for 3072 in 8 kB.
#ifndef VALVE_MAX_ENTRIES
#define VALVE_MAX_ENTRIES 3072
#endif

enum {
  VALVE_FIRMWARE = 2,          // version that HELLO tells
  VALVE_STEP_US = 50,          // of the tick interrupt: edges fall on these steps
  VALVE_SPIKE_US = 300,        // 24 V at the begin of a pulse, then 3.5 V [Barnett 2012, 2.3.1]
  VALVE_MIN_PULSE_US = 500,    // by the valve's manufacturer
  VALVE_MAX_PULSE_US = 50000,  // longest continuous open time (interlock 12)
  VALVE_MAX_DUTY_PERCENT =
      75,  // of open time in the mean (interlock 12): above it for 2 s of open time ends in FAULT
  VALVE_GUARD_US = 100,  // closed between two pulses
  VALVE_MAX_PAYLOAD = 512,
  VALVE_MAX_FRAME = 6 + VALVE_MAX_PAYLOAD + 2,
  VALVE_MAX_REPLY = 32
};

// Outputs.
enum { VALVE_CLOSED = 0, VALVE_SPIKE = 1, VALVE_HOLD = 2 };

// States as FVB/1 numbers them.
enum { VALVE_IDLE, VALVE_LOADING, VALVE_LOADED, VALVE_ARMED, VALVE_FIRING, VALVE_DONE, VALVE_FAULT };

// Why a list ended.
enum {
  VALVE_NOT_ENDED,
  VALVE_THROUGH,
  VALVE_DISARMED,
  VALVE_ABORTED,
  VALVE_WATCHDOG,
  VALVE_DISABLED,
  VALVE_TOO_HOT
};

struct valve {
  // Set by the port, then constant.
  uint16_t boots;
  uint8_t reset_cause;     // 0 power, 1 watchdog, 2 pin, 3 brown-out
  uint16_t pause_steps;    // silence within a frame after which its bytes are dropped
  uint32_t silence_steps;  // without a frame while firing: closed

  // Frames.
  uint8_t frame[VALVE_MAX_FRAME];
  uint16_t frame_size;
  uint16_t quiet_steps;  // since the last byte
  uint8_t reply[VALVE_MAX_REPLY];
  uint8_t reply_size;
  uint8_t answer[VALVE_MAX_REPLY];  // the reply to the last number, for its repetition
  uint8_t answer_size;
  uint8_t last_number;
  bool known;

  // The list.
  uint16_t ticks[VALVE_MAX_ENTRIES];
  uint16_t held;
  uint32_t path;
  uint16_t entries, tick_us, pulse_us;
  bool spits;  // no list: entries pulses, one a tick

  // Firing. The tick interrupt changes these.
  volatile uint8_t state;
  volatile uint8_t end;     // why the last list ended
  volatile uint8_t output;  // VALVE_CLOSED, VALVE_SPIKE or VALVE_HOLD
  volatile uint16_t fired;
  volatile uint16_t late_us;      // latest pulse against its time
  volatile uint32_t since_us;     // since the trigger
  uint32_t next_us;               // begin of the next pulse, since the trigger
  uint16_t open_us;               // of the pulse under way
  volatile uint32_t wait_steps;   // until an armed list is disarmed; 0: for ever
  volatile uint32_t heard_steps;  // since the last frame
  int32_t heat;
};

// Supplied by the port: no tick interrupt between the two.
void valve_lock(void);
void valve_unlock(void);

void valve_init(struct valve* v, uint16_t boots, uint8_t reset_cause);
// One byte of the serial line. Afterwards reply_size bytes of reply are to be sent, if any.
void valve_receive(struct valve* v, uint8_t byte);
// In the tick interrupt, every VALVE_STEP_US; then the port sets its pins by v->output.
void valve_step(struct valve* v);
void valve_trigger(struct valve* v);  // the robot's line rises
void valve_disable(struct valve* v);  // its enable line falls

#ifdef __cplusplus
}
#endif

#endif
