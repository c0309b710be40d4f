// DriverNode holds the common part of all instruments' nodes: the lease, epochs, commands that arrive twice,
// answers, states, faults, timers. `Driver` is a pure state machine with the calls of drivers/link/driver.h,
// which fill `Effects`; both are parameters, because the runtime knows no driver.
#pragma once

#include <any>
#include <string>
#include <tuple>
#include <utility>
#include <variant>

#include "firn/answer_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/safe_stop_t.hpp"
#include "firn/service_order_t.hpp"
#include "lcmtypes/convert.h"
#include "runtime/answering_node.h"
#include "runtime/device_guard.h"
#include "runtime/node.h"
#include "runtime/python_port.h"

namespace firn {

/// How long a live host may take between an event and its handling, in node time: a driver's timeouts allow
/// for it.
inline double host_latency_s(double time_scale) { return 0.25 * time_scale; }

namespace detail {
template <class Node, class Measurement>
concept Takes = requires(Node& node, Measurement& value, Time now, Outbox& out) {
  node.on_measured(value, now, out);
};
template <class Node, class List>
inline constexpr bool kTakesAll = false;
template <class Node, class... Measurements>
inline constexpr bool kTakesAll<Node, std::tuple<Measurements...>> = (Takes<Node, Measurements> && ...);
}  // namespace detail

/// The node has `on_measured(value, now, out)` for every type that the driver measures (its list
/// `Measurements`).
template <class Node, class Driver>
concept TakesMeasurements = detail::kTakesAll<Node, typename Driver::Measurements>;

/// `Self` derives from it, has `on(command, now, out)` for its commands, which ends in perform(), and takes
/// the measurements of its driver.
template <class Self, class Driver, class Effects>
class DriverNode : public Node, public AnsweringNode {
 public:
  template <class Config>
  DriverNode(NodeId id, Config&& config) : driver_(std::forward<Config>(config)), id_(id) {
    static_assert(TakesMeasurements<Self, Driver>, "a measurement of the driver has no on_measured()");
    subscribe(channels::kEnable, this);
    subscribe(channels::kSafeStop, this);
    if constexpr (requires(Effects & fx) { driver_.serve("", {}, std::int64_t{}, fx); })
      subscribe(channels::kServiceOrder, this);
  }

  /// The instrument's; of a driver class in Python that speaks through it, then the class's own.
  std::vector<std::string> ports() const override {
    std::string name(info(id_).name);
    if (!has_line()) return {std::move(name)};
    return {name, python_port(name)};
  }
  bool answered() const override { return driver_.answered(); }
  const std::string& last_not_understood() const override { return driver_.last_not_understood(); }

  void start(const Start& start, Time now, Outbox& out) override {
    incarnation_ = start.incarnation;
    armed_us_ = 0;  // timers end with an incarnation
    lease_armed_ = false;
    acting_ = false;
    // Node time goes on where the crash cut it, so the old lease may seem to last: it does not, and a command
    // of its epoch that arrives only now is refused.
    if (start.resumed()) guard_.local_stop();
    if constexpr (requires { driver_.permit_reset(); })
      if (start.resumed()) driver_.permit_reset();
    if constexpr (requires { driver_.resumed(); })
      if (start.resumed()) driver_.resumed();
    starting_ = start.resumed();
    step(now, out, [&] {  // whatever the links were: the ports are opened anew
      driver_.closed(now.us, fx_);
      if constexpr (kMayHaveLine)
        if (driver_.has_line()) driver_.line_closed(now.us, fx_);
    });
    starting_ = false;
  }

  void wake(TimerId timer, Time now, Outbox& out) override {
    if (timer == kLease) return check_lease(now, out);
    armed_us_ = 0;
    step(now, out, [&] { driver_.woke(now.us, fx_); });
  }

  void on_io(PortId port, std::span<const std::byte> bytes, Time now, Outbox& out) override {
    if constexpr (kMayHaveLine)
      if (port != main_port()) return step(now, out, [&] { driver_.line_received(bytes, now.us, fx_); });
    step(now, out, [&] { driver_.received(bytes, now.us, fx_); });
  }

  void on_link(PortId port, LinkState link, Time now, Outbox& out) override {
    if constexpr (kMayHaveLine)
      if (port != main_port())
        return step(now, out, [&] {
          link == LinkState::kOpen ? driver_.line_opened(now.us, fx_) : driver_.line_closed(now.us, fx_);
        });
    step(now, out,
         [&] { link == LinkState::kOpen ? driver_.opened(now.us, fx_) : driver_.closed(now.us, fx_); });
  }

  void local_stop(std::string_view cause, Time now, Outbox& out) override {
    guard_.local_stop();
    make_safe(cause, now, out);
  }

  void on(const enable_t& m, Time now, Outbox&) {
    guard_.enable(m.enable_epoch, m.enabled, m.lease_s, Time{m.header.utime_us}, now);
  }

  void on(const safe_stop_t& m, Time now, Outbox& out) {
    if (guard_.safe_stop(m.enable_epoch)) return make_safe(m.cause, now, out);
    if (m.enable_epoch == guard_.epoch() && !stop_pending_ && driver_.safe())
      send_state("stopped", out);  // ours was lost
  }

  void on(const service_order_t& m, Time now, Outbox& out) {
    if (m.node != info(id_).name) return;
    perform(m, true, now, out, [&](Driver& driver, std::int64_t now_us, Effects& fx) {
      driver.serve(m.verb, m.values, now_us, fx);
    });
  }

  bool writes_need_lease() const override { return in_progress_ && acting_ && !stop_pending_; }
  std::string lease_refusal(Time now, std::int64_t stop_epoch) const override {
    return guard_.lease_refusal(now, stop_epoch);
  }

  // Of a command whose first bytes were kept back the instrument knows nothing; of one that had begun the
  // driver finds out how far it came.
  void on_refused(PortId, std::string_view cause, Time now, Outbox& out) override {
    if (in_progress_ && writes_ == 1) {
      in_progress_ = false;
      answer_.outcome = std::int8_t(Outcome::kNone);
      answer_.counted = 0;
      answer_.text = "nothing was sent: " + std::string(cause);
      out.send(channels::answer(id_), answer_);
    }
    out.report(Severity::kStop, "command " + std::to_string(answer_.command_id) +
                                    " was kept from the port: " + std::string(cause));
    local_stop(cause, now, out);
  }

  const Driver& driver() const { return driver_; }
  std::int32_t incarnation() const { return incarnation_; }

 protected:
  /// Runs `act` unless the command was seen before (then its answer is sent again, it is never executed
  /// twice), the lease forbids it, or another command is in progress. With `irreversible`, the command stands
  /// on the disk before anything leaves this step. The ranges of its fields were checked when it was received
  /// (lcmtypes/validate.h).
  template <class Command, class Act>
  void perform(const Command& c, bool irreversible, Time now, Outbox& out, Act&& act) {
    if (c.command_id == answer_.command_id) {
      if (!in_progress_) out.send(channels::answer(id_), answer_);
      return;
    }
    if (c.command_id < answer_.command_id) return;  // older than the last answer
    std::string why = guard_.command_refusal(c.enable_epoch, now);
    if (why.empty() && in_progress_)
      why = "command " + std::to_string(answer_.command_id) + " is still in progress";
    if (!why.empty()) {
      answer_t refused = blank_answer(c.command_id);
      refused.outcome = std::int8_t(Outcome::kRefused);
      refused.text = why;
      if (!in_progress_) answer_ = refused;
      return out.send(channels::answer(id_), std::move(refused));
    }
    answer_ = blank_answer(c.command_id);
    in_progress_ = true;
    acting_ = true;
    writes_ = 0;
    if (irreversible) out.durable();
    watch_lease(out);
    step(now, out, [&] { act(driver_, now.us, fx_); });
  }

  /// A call of the driver that is no command: nothing is answered.
  template <class Act>
  void act(Time now, Outbox& out, Act&& call) {
    step(now, out, [&] { call(driver_, now.us, fx_); });
  }

  Driver driver_;

 private:
  static constexpr TimerId kDriver{1}, kLease{2};
  static constexpr bool kMayHaveLine = requires(Effects & fx) { fx.line_tx; };

  bool has_line() const {
    if constexpr (kMayHaveLine) return driver_.has_line();
    return false;
  }
  PortId main_port() const { return PortId(has_line() ? 1 : 0); }

  answer_t blank_answer(std::int64_t command_id) const {
    answer_t a{};
    a.node = info(id_).name;
    a.command_id = command_id;
    a.counted = -1;
    return a;
  }

  template <class Act>
  void step(Time now, Outbox& out, Act&& act) {
    fx_.clear();
    act();
    bool state_sent = false;
    const bool stopped = stop_pending_ && driver_.safe();
    if (stopped) stop_pending_ = false;  // from here on the new epoch is honoured
    for (auto& event : fx_.events)
      std::visit([&](auto& e) { state_sent = handle(e, now, out) || state_sent; }, event);
    if (stopped && !state_sent) send_state("stopped", out);
    bool wrote = !fx_.tx.empty();
    if constexpr (kMayHaveLine) {  // the instrument before the program
      if (!fx_.line_tx.empty()) out.write(PortId{0}, fx_.line_tx);
      wrote = wrote || !fx_.line_tx.empty();
      if (fx_.reopen_line) out.reopen(PortId{0});
    }
    if (!fx_.tx.empty()) out.write(main_port(), fx_.tx);
    if (wrote && in_progress_) ++writes_;
    if (fx_.reopen) out.reopen(main_port());
    if (fx_.wake_us != 0 && (armed_us_ == 0 || fx_.wake_us < armed_us_)) {
      armed_us_ = fx_.wake_us;  // a later wake waits for the earlier one, which does no harm
      out.wake_at(kDriver, Time{armed_us_});
    }
  }

  template <class Measurement>
  void deliver_as(std::any& value, Time now, Outbox& out) {
    if (Measurement* m = std::any_cast<Measurement>(&value))
      static_cast<Self*>(this)->on_measured(*m, now, out);
  }
  template <class... Measurements>
  void deliver(std::any& value, [[maybe_unused]] Time now, [[maybe_unused]] Outbox& out,
               std::tuple<Measurements...>*) {
    (deliver_as<Measurements>(value, now, out), ...);
  }

  template <class Event>
  bool handle(Event& e, Time now, Outbox& out) {
    if constexpr (requires { e.outcome; }) {
      if (!in_progress_) return false;
      in_progress_ = false;
      answer_.outcome = std::int8_t(e.outcome);
      answer_.counted = e.counted;
      answer_.expected = e.expected;
      answer_.unknown_from = e.unknown_from;
      answer_.unknown_to = e.unknown_to;
      answer_.until_utime_us = e.until_us;
      answer_.code = e.code;
      answer_.text = e.text;
      answer_.figure = to_message(e.figure);
      out.send(channels::answer(id_), answer_);
    } else if constexpr (requires { e.state; }) {
      send_state(e.text, out);
      return true;
    } else if constexpr (requires { e.severity; }) {
      const bool old =
          starting_ && e.severity == Severity::kStop;  // an old incarnation's loss stops no new one
      out.report(old ? Severity::kWarning : e.severity, e.text, e.code, e.figure);
    } else if constexpr (requires { e.value; }) {
      deliver(e.value, now, out, static_cast<typename Driver::Measurements*>(nullptr));
    }
    return false;
  }

  void send_state(std::string_view text, Outbox& out) {
    if (!stop_pending_) honoured_epoch_ = guard_.epoch();
    device_state_t s{};
    s.node = info(id_).name;
    s.state = std::int8_t(driver_.state());
    s.enable_epoch = honoured_epoch_;
    s.identity = driver_.identity();
    s.text = text;
    out.send(channels::device_state(id_), std::move(s));
  }

  void make_safe(std::string_view, Time now, Outbox& out) {
    stop_pending_ = true;
    step(now, out, [&] { driver_.safe_stop(now.us, fx_); });
  }

  void watch_lease(Outbox& out) {
    if (lease_armed_) return;
    lease_armed_ = true;
    out.wake_at(kLease, Time{guard_.lease_until().us + 1});
  }

  void check_lease(Time now, Outbox& out) {
    lease_armed_ = false;
    if (driver_.safe() && !in_progress_) return;
    if (guard_.allowed(now)) return watch_lease(out);
    if (stop_pending_) return;
    out.report(Severity::kStop, "the lease ended at " + std::to_string(guard_.lease_until().s()) +
                                    " s with a command in progress");
    local_stop("the lease ended", now, out);
  }

  NodeId id_;
  DeviceGuard guard_;
  Effects fx_;
  answer_t answer_ = answer_t{};  // to the last command; its id is that of the command in progress
  std::int32_t incarnation_ = 0;
  bool in_progress_ = false;
  bool acting_ = false;        // it was begun in this incarnation; of an older one the driver only asks
  int writes_ = 0;             // steps of the command in progress that put bytes out
  bool stop_pending_ = false;  // asked to be safe, not confirmed
  bool starting_ = false;
  bool lease_armed_ = false;
  std::int64_t honoured_epoch_ = 0;
  std::int64_t armed_us_ = 0;
};

}  // namespace firn
