#include "procs/safety/node.h"

#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/safe_stop_t.hpp"

namespace firn {
namespace {

constexpr TimerId kTick{1};
constexpr int kSilentTicks =
    10;  // own ticks without a heartbeat; own ticks, so that a late safety accuses nobody

}  // namespace

Safety::Safety(const Experiment& experiment) : config_(experiment.run) {
  for (const NodeInfo& n : nodes()) {
    driver_[std::size_t(n.id)] = n.driver && takes_part(experiment, n.name);
    if (n.id != NodeId::kSafety) {
      subscribe(channels::fault(n.id), this);
      subscribe(channels::heartbeat(n.id), this);
    }
    if (n.driver) subscribe(channels::device_state(n.id), this);
  }
  subscribe(channels::kRunEnd, this);
  subscribe(channels::kOperatorCommand, this);
}

void Safety::start(const Start& start, Time now, Outbox& out) {
  incarnation_ = start.incarnation;
  // The epoch goes on through a resume: commands of before it stay refused.
  ++epoch_;
  cause_.clear();
  phase_ = Phase::kWaiting;
  drivers_ = {};
  silent_ticks_.fill(-1);
  busy_since_us_.fill(0);
  send_enable(out);
  out.wake_at(kTick, period_after(now));
}

void Safety::wake(TimerId, Time now, Outbox& out) {
  if (phase_ == Phase::kOver || phase_ == Phase::kStopped) return;
  if (phase_ == Phase::kStopping) {
    send_stop(out);
  } else {
    check_heartbeats(now, out);
    if (phase_ != Phase::kStopping) send_enable(out);
  }
  out.wake_at(kTick, period_after(now));
}

// Messages of an earlier incarnation are not valid in this one: the resume is the operator's reset.
void Safety::on(const fault_t& f, Time now, Outbox& out) {
  if (f.header.incarnation < incarnation_) return;
  if (Severity(f.severity) == Severity::kStop) stop(f.node + ": " + f.text, now, out);
}

void Safety::on(const device_state_t& m, Time now, Outbox& out) {
  const NodeInfo* node = find_node(m.node);
  if (!node || !node->driver || m.header.incarnation < incarnation_) return;
  drivers_[std::size_t(node->id)] = {m.state, m.enable_epoch, true};
  if (both_jets_armed()) stop("both jets are armed: a pulse would fire the two inks at once", now, out);
  if (phase_ == Phase::kWaiting && all_safe(0)) {
    phase_ = Phase::kEnabled;
    send_enable(out);
  }
  if (phase_ == Phase::kStopping && all_safe(epoch_)) {
    phase_ = Phase::kStopped;
    send_stop(out);
    out.finish(3, cause_);
  }
}

void Safety::on(const heartbeat_t& h, Time, Outbox&) {
  if (const NodeInfo* node = find_node(h.node)) {
    silent_ticks_[std::size_t(node->id)] = 0;
    busy_since_us_[std::size_t(node->id)] = h.busy_since_us;
  }
}

void Safety::on(const run_end_t& end, Time, Outbox& out) {
  if (phase_ == Phase::kStopping || phase_ == Phase::kStopped || end.header.incarnation < incarnation_)
    return;
  phase_ = Phase::kOver;
  send_enable(out);  // not enabled: the lease ends now
  out.cancel(kTick);
  out.finish(0, end.reason);
}

void Safety::on(const operator_command_t& m, Time now, Outbox& out) {
  if (OperatorVerb(m.verb) == OperatorVerb::kStop && m.header.incarnation >= incarnation_)
    stop("stopped by the operator", now, out);
}

void Safety::local_stop(std::string_view cause, Time now, Outbox& out) { stop(std::string(cause), now, out); }

void Safety::stop(const std::string& cause, Time now, Outbox& out) {
  if (phase_ == Phase::kStopping || phase_ == Phase::kStopped) return;
  phase_ = Phase::kStopping;
  ++epoch_;
  cause_ = cause;
  send_stop(out);
  out.wake_at(kTick, period_after(now));
}

void Safety::send_enable(Outbox& out) {
  enable_t m{};
  m.enable_epoch = epoch_;
  m.enabled = phase_ == Phase::kEnabled;
  m.lease_s = config_.lease_s * config_.time_scale;
  out.send(channels::kEnable, m);
}

void Safety::send_stop(Outbox& out) {
  safe_stop_t m{};
  m.enable_epoch = epoch_;
  m.cause = cause_;
  out.send(channels::kSafeStop, m);
}

// A driver with no link cannot answer SAFE; only the watchdog of its instrument is left then, and its FAULT
// reports the link loss. SUSPECT or FAULT states count as not safe.
bool Safety::all_safe(std::int64_t epoch) const {
  for (const NodeInfo& n : nodes()) {
    if (!driver_[std::size_t(n.id)]) continue;
    const HeardState& d = drivers_[std::size_t(n.id)];
    if (!d.heard || DeviceState(d.state) != DeviceState::kSafe || d.epoch < epoch) return false;
  }
  return true;
}

// One pulse line serves both jets: the armed one fires.
bool Safety::both_jets_armed() const {
  for (const NodeId jet : {NodeId::kJet, NodeId::kJetB}) {
    const HeardState& d = drivers_[std::size_t(jet)];
    if (!d.heard ||
        (DeviceState(d.state) != DeviceState::kArmed && DeviceState(d.state) != DeviceState::kActive))
      return false;
  }
  return true;
}

void Safety::check_heartbeats(Time now, Outbox& out) {
  for (const NodeInfo& n : nodes()) {
    int& silent = silent_ticks_[std::size_t(n.id)];
    if (silent < 0) continue;  // no heartbeat yet: the launcher watches processes that never started
    if (++silent > kSilentTicks)
      return stop(
          std::string(n.name) + " has sent no heartbeat for " + std::to_string(kSilentTicks) + " periods",
          now, out);
    const std::int64_t since = busy_since_us_[std::size_t(n.id)];
    const double busy_s = since ? seconds_between(Time{since}, now) / config_.time_scale : 0.0;
    if (busy_s > n.longest_step_s)
      return stop(std::string(n.name) + " has been busy with one step for " + std::to_string(busy_s) +
                      " s; " + std::to_string(n.longest_step_s) + " s are allowed",
                  now, out);
  }
}

std::unique_ptr<Node> make_safety(const std::string& config_toml, const Blobs&) {
  return std::make_unique<Safety>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
