// Safety leases permission to the drivers: FAULT_*, STATE_*, HEARTBEAT_* -> ENABLE (the lease),
// SAFE_STOP.
#pragma once

#include <array>
#include <string>

#include "config/experiment.h"
#include "firn/device_state_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/heartbeat_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Grants the lease once every driver has answered SAFE in this incarnation, renews it every period, and
/// withdraws it permanently on the first fault of severity 2, a missing heartbeat or a step that takes too
/// long: the epoch is raised and SAFE_STOP repeated until every driver honours it. There is no way back
/// inside an incarnation: the reset edge is a new start by the operator (latch, docs/safety.md).
class Safety : public Node {
 public:
  explicit Safety(const Experiment& experiment);

  void start(const Start&, Time now, Outbox&) override;
  void wake(TimerId, Time now, Outbox&) override;
  void local_stop(std::string_view cause, Time now, Outbox&) override;
  void on(const fault_t&, Time now, Outbox&);
  void on(const device_state_t&, Time now, Outbox&);
  void on(const heartbeat_t&, Time now, Outbox&);
  void on(const run_end_t&, Time now, Outbox&);
  void on(const operator_command_t&, Time now, Outbox&);

 private:
  enum class Phase { kWaiting, kEnabled, kStopping, kStopped, kOver };
  struct HeardState {
    int state = 0;
    std::int64_t epoch = -1;
    bool heard = false;  ///< in this incarnation
  };

  void stop(const std::string& cause, Time now, Outbox&);
  void send_enable(Outbox&);
  void send_stop(Outbox&);
  bool all_safe(std::int64_t epoch) const;
  bool both_jets_armed() const;
  void check_heartbeats(Time now, Outbox&);

  Time period_after(Time now) const { return now.after_s(config_.safety_period_s * config_.time_scale); }

  RunConfig config_;
  std::array<bool, kNodeCount> driver_{};  ///< the drivers that take part
  Phase phase_ = Phase::kOver;
  std::int32_t incarnation_ = 0;
  std::int64_t epoch_ = 0;
  std::string cause_;
  std::array<HeardState, kNodeCount> drivers_;
  std::array<int, kNodeCount> silent_ticks_{};  ///< own ticks since the last heartbeat; -1 = no heartbeat yet
  std::array<std::int64_t, kNodeCount> busy_since_us_{};
};

std::unique_ptr<Node> make_safety(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
