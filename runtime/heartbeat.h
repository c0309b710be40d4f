// Heartbeat runs the runner's own thread that says "alive" ten times a second of wall time, also while a step
// takes long.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "runtime/bus.h"
#include "runtime/event.h"
#include "runtime/run_clock.h"
#include "runtime/transport.h"

namespace firn {

class Heartbeat {
 public:
  enum State : int { kStarting = 0, kRunning = 1, kStopping = 2 };

  Heartbeat(NodeId node, std::int64_t run_id, std::int32_t incarnation, const RunClock& clock, Bus& bus);
  ~Heartbeat();

  void set_state(State state) { state_ = state; }
  void set_busy(bool busy) { busy_since_us_ = busy ? clock_.now().us : 0; }
  /// The step that was handled last, for JOURNAL_<NODE>: at most one a beat goes out, for people who watch.
  struct Step {
    std::uint64_t number = 0;  ///< steps handled; 0 = none yet
    EventKind kind = EventKind::kStart;
    std::string_view channel;  ///< in the channel table, or empty
    int outputs = 0;
    std::int64_t output_bytes = 0;
  };
  void note(const Step& step);
  /// Contents of the next beats.
  void update(std::uint64_t steps, const TransportStats& stats, std::vector<Transport::Last> last);

 private:
  void run();
  std::vector<std::byte> encode();
  std::vector<std::byte> encode_journal();

  NodeId node_;
  std::int64_t run_id_;
  std::int32_t incarnation_;
  RunClock clock_;
  Bus& bus_;
  std::int64_t seq_ = 0;
  std::atomic<int> state_{kStarting};
  std::atomic<std::int64_t> busy_since_us_{0};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool over_ = false;
  std::uint64_t steps_ = 0;
  TransportStats stats_;
  std::vector<Transport::Last> last_;
  Step step_;
  std::uint64_t journal_told_ = 0;
  std::int64_t journal_seq_ = 0;
  std::thread thread_;
};

}  // namespace firn
