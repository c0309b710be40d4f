// Passes any bytes to the valve's firmware, with ticks of its clock, triggers and the enable line between
// them: its buffers keep their bounds, its coil is closed in every state but FIRING, and each reply is a
// frame.
#include <algorithm>

#include "drivers/valve/fvb.h"
#include "firmware/valve/valve.h"
#include "tests/fuzz/require.h"

using namespace firn::fuzz;
namespace fvb = firn::drivers::fvb;

namespace {

void hold(const valve& v) {
  require(v.frame_size < VALVE_MAX_FRAME, "the frame's buffer has room for the next byte");
  require(v.reply_size <= VALVE_MAX_REPLY && v.answer_size <= VALVE_MAX_REPLY, "a reply fits");
  require(v.held <= VALVE_MAX_ENTRIES && (v.spits || v.entries <= VALVE_MAX_ENTRIES), "a list fits");
  require(v.fired <= v.entries, "no more pulses than asked for");
  require(v.state <= VALVE_FAULT, "a state that has a name");
  require(v.output == VALVE_CLOSED || v.state == VALVE_FIRING, "the coil is closed unless a list fires");
  require(v.heat >= 0, "heat is not below 0");
}

void run(valve& v, int steps) {
  for (int n = 0; n < steps; ++n) valve_step(&v);
  hold(v);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static valve v;
  valve_init(&v, 1, 0);
  for (std::size_t n = 0; n < size; ++n) {
    valve_receive(&v, data[n]);
    hold(v);
    if (v.reply_size > 0) {
      const fvb::Found f = fvb::find(std::as_bytes(std::span(v.reply, v.reply_size)));
      require(f.kind == fvb::Found::Kind::kFrame && f.size == v.reply_size, "a reply is one whole frame");
      // What happens beside the line between two requests, drawn from the request itself.
      if (f.seq % 4 == 1) valve_trigger(&v);
      if (f.seq % 16 == 3) valve_disable(&v);
      run(v, f.seq);
    }
    if (data[n] == 0xEE) run(v, 1100);  // a pause within a frame
  }
  return 0;
}
