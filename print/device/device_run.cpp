#include "print/device/device_run.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "drivers/link/driver_event.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "firn/enums.h"
#include "firn/laser_samples_t.hpp"
#include "lcmtypes/validate.h"
#include "print/device/device_session.h"
#include "print/folder/taking_part.h"

namespace firn {
namespace {

constexpr double kIdentifyWithin_s = 10.0;
constexpr double kAnswered_s = 0.3;    // after its first bytes an instrument has named itself, if it can
constexpr double kFirstBytes_s = 2.0;  // an instrument that has said nothing by then is silent
constexpr double kForEver_s = 1e8;

// An order that its message cannot carry would be dropped by the node, and waited for.
void check_order(const DeviceJob& job) {
  const DeviceCall call{job.e, job.node, job.verb->name, job.values, job.far};
  OrderStamp stamp{{}, 1, 1};
  stamp.header.run_id = stamp.header.seq = stamp.header.utime_us = 1;
  for (const MakeOrder make : {job.verb->order, job.verb->after}) {
    if (!make) continue;
    const DeviceOrder order = make(call, stamp);
    if (const auto why = validate(*find_channel(order.channel), order.bytes))
      throw UsageError(std::string(job.verb->name) + ": " + *why);
  }
}

template <class Message>
bool decoded(Message& m, std::string_view channel, std::string_view wanted,
             std::span<const std::byte> bytes) {
  return channel == wanted && m.decode(bytes.data(), 0, int(bytes.size())) > 0;
}

// One session: its parts run in this order.
class Run {
 public:
  Run(const DeviceJob& job, const PortAddress& address, const DeviceSinks& sinks)
      : job_(job),
        sinks_(sinks),
        first_bytes_s_(address.kind == PortAddress::Kind::kCassette
                           ? kForEver_s
                           : kFirstBytes_s + 1e-3 * double(address.open_wait_ms)),
        session_(make(), address, session_sinks()) {}

  DeviceReport carry_out() {
    if (become_ready() && job_.verb->order) give_orders();
    const bool measures = job_.node == "heater" || job_.node == "gas";
    if (report_.status == kOk && !job_.verb->order && measures && job_.verb->name != "identify")
      until([this] { return report_.temperature || report_.gas; }, kIdentifyWithin_s);
    if (report_.status == kOk && sinks_.watch) {
      until([] { return false; }, kForEver_s);
      fail(kInterrupted, "watched");
    }
    end();
    report_.state = session_.state();
    return std::move(report_);
  }

 private:
  struct Made {
    NodeId id;
    std::unique_ptr<Node> node;
  };
  struct Opened : DeviceSession {
    Opened(Made made, const PortAddress& address, Sinks sinks)
        : DeviceSession(made.id, std::move(made.node), address, std::move(sinks)) {}
  };

  Made make() const {
    Experiment e = job_.e;
    if (job_.verb->asks) e.stage.home_at_start = OnOff::kOff;
    for (const NamedMaker& m : taking_part(job_.product, job_.e))
      if (info(m.id).name == job_.node) return {m.id, m.make(dump(e), {})};
    throw UsageError("the lab has no instrument '" + job_.node + "'");
  }

  DeviceSession::Sinks session_sinks() {
    DeviceSession::Sinks s;
    if (sinks_.tape) s.tape = [this](const std::string& line) { sinks_.tape(line, ordered_); };
    s.note = sinks_.note;
    s.message = [this](std::string_view channel, std::span<const std::byte> bytes) { take(channel, bytes); };
    return s;
  }

  void take(std::string_view channel, std::span<const std::byte> bytes) {
    if (temperature_t t; decoded(t, channel, channels::kTemperature.name, bytes)) report_.temperature = t;
    if (gas_flow_t g; decoded(g, channel, channels::kGasFlow.name, bytes)) report_.gas = g;
    if (height_profile_t p; decoded(p, channel, channels::kHeightProfile.name, bytes))
      report_.profiles.push_back(std::move(p));
    if (camera_frame_t f; decoded(f, channel, channels::kCameraFrame.name, bytes))
      report_.frames.push_back(std::move(f));
    if (laser_samples_t l; decoded(l, channel, channels::kLaserSamples.name, bytes))
      report_.readings_mm.insert(report_.readings_mm.end(), l.distance_mm.begin(), l.distance_mm.end());
    device_state_t state{};
    if (sinks_.state && channel.starts_with("STATE_") && state.decode(bytes.data(), 0, int(bytes.size())) > 0)
      sinks_.state(state);
  }

  bool until(const std::function<bool()>& done, double within_s) {
    return session_.run_until(done, within_s, sinks_.interrupted);
  }
  bool interrupted() const { return sinks_.interrupted && sinks_.interrupted(); }
  void fail(int status, std::string text) {
    report_.status = interrupted() ? int(kInterrupted) : status;
    report_.text = std::move(text);
  }

  /// Who answers is known before it is safe.
  bool named() const {
    const auto state = session_.state() ? DeviceState(session_.state()->state) : DeviceState::kDisconnected;
    return session_.answered() && session_.heard_for_s() > kAnswered_s && state != DeviceState::kSuspect &&
           state != DeviceState::kDisconnected;
  }

  bool become_ready() {
    const bool identifies = job_.verb->name == "identify";
    const bool resets = job_.verb->name == "reset";  // one that is not safe, or says nothing good
    const double within_s = identifies || resets ? std::min(kIdentifyWithin_s, job_.within_s) : job_.within_s;
    const auto ready = [&] {
      return session_.safe() || (identifies && named()) || (resets && session_.heard_for_s() > kAnswered_s);
    };
    const auto silent = [&] {
      return session_.heard_for_s() == 0.0 && session_.lasts_s() >= std::min(first_bytes_s_, within_s);
    };
    if (until([&] { return ready() || silent(); }, within_s) && !silent()) {
      const bool in_order = !identifies || DeviceState(session_.state()->state) != DeviceState::kFault;
      if (!in_order) fail(kFailed, "it answers, and is in fault");
      return in_order;
    }
    fail(kSafetyStop,
         fmt::format("{} within {:g} s{}",
                     session_.heard_for_s() > 0.0 ? "it answers, and is not safe"
                     : session_.state()           ? "no answer"
                                                  : "its port does not open",
                     silent() ? std::min(first_bytes_s_, within_s) : within_s, session_.not_understood()));
    return false;
  }

  void give_orders() {
    ordered_ = true;
    const auto& values = job_.values;
    const int times = job_.verb->repeats ? int(std::clamp(values[0], 1.0, 1e6)) : 1;
    for (int n = 0; n < times && report_.status == kOk; ++n) give(job_.verb->order);
    if (report_.status != kOk) return;
    if (job_.verb->name == "reset" && !until([this] { return session_.safe(); }, job_.within_s))
      return fail(kSafetyStop, fmt::format("it is not safe {:g} s after the reset{}", job_.within_s,
                                           session_.not_understood()));
    if (job_.verb->after) {
      const auto rows = std::size_t(std::max(0.0, values.front()));
      until([&] { return report_.profiles.size() >= rows; }, values.back());
      give(job_.verb->after);
      if (report_.status == kOk)
        report_.text = fmt::format("{} of {} profiles", report_.profiles.size(), rows);
    }
    if (job_.verb->repeats || !report_.readings_mm.empty())
      report_.text = readings_text(job_, report_.readings_mm);
  }

  void give(MakeOrder make) {
    const DeviceCall call{job_.e, job_.node, job_.verb->name, job_.values, job_.far};
    std::string words(job_.verb->name);
    for (const double value : job_.values) words += fmt::format(" {:g}", value);
    session_.command([&](const OrderStamp& stamp) { return make(call, stamp); }, words);
    if (!until([this] { return session_.answer().has_value(); }, job_.within_s))
      return fail(kSafetyStop, fmt::format("the command did not end within {:g} s", job_.within_s));
    const answer_t& a = *session_.answer();
    const auto outcome = Outcome(a.outcome);
    report_.text = std::string(drivers::name(outcome)) + (a.text.empty() ? "" : ": " + a.text);
    if (outcome != Outcome::kDone && !(outcome == Outcome::kReady && job_.verb->after))
      fail(kFailed, report_.text);
  }

  void end() {
    const bool asked = job_.verb->name == "stop";
    if (!asked && report_.status == kOk) return;
    if (!session_.stop(asked ? "firn device stop" : report_.text) && asked)
      fail(kSafetyStop, "it did not confirm that it is safe");
  }

  const DeviceJob& job_;
  const DeviceSinks& sinks_;
  double first_bytes_s_;
  DeviceReport report_;
  bool ordered_ = false;
  Opened session_;
};

}  // namespace

DeviceReport run_verb(const DeviceJob& job, const PortAddress& address, const DeviceSinks& sinks) {
  check_order(job);
  return Run(job, address, sinks).carry_out();
}

std::string readings_text(const DeviceJob& job, const std::vector<double>& readings_mm) {
  double sum = 0.0, low = INFINITY, high = -INFINITY;
  std::size_t n = 0;
  for (const double mm : readings_mm) {
    if (std::isnan(mm)) continue;
    sum += mm;
    low = std::min(low, mm);
    high = std::max(high, mm);
    ++n;
  }
  if (n == 0) return fmt::format("no value in {} readings", readings_mm.size());
  const double mean = sum / double(n);
  if (!job.verb->repeats) return fmt::format("{:.4f} mm", mean);
  if (job.verb->name == "zero")
    return fmt::format("laser_point.offset_z_mm = {:.4f} makes the mean of {} readings 0",
                       job.e.laser_point.offset_z_mm - mean, n);
  double squares = 0.0;
  for (const double mm : readings_mm)
    if (!std::isnan(mm)) squares += (mm - mean) * (mm - mean);
  return fmt::format("mean {:.4f}, standard deviation {:.4f}, from {:.4f} to {:.4f} mm; {} of {} readings",
                     mean, n > 1 ? std::sqrt(squares / double(n - 1)) : 0.0, low, high, n,
                     readings_mm.size());
}

}  // namespace firn
