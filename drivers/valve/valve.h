// Valve controls a micro-solenoid valve behind FVB/1. It holds pulse lists, loads one, arms it for the
// robot's signal, watches it fire and reports the number of pulses. The microcontroller holds one list; the
// next one goes over as soon as it is free.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/link/driver.h"
#include "drivers/valve/fvb.h"
#include "drivers/valve/valve_drive_config.h"

namespace firn::drivers {

struct ValveOptions : ValveDriveConfig {
  int valve = 1;  ///< 1 valve_a (water), 2 valve_b (scaffold)
  bool upload_ahead = true;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

/// List `list` of path `path`.
struct ListName {
  std::int64_t path = 0;
  std::int32_t list = 0;
  auto operator<=>(const ListName&) const = default;
  std::string text() const;
};

class Valve final : public Driver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Valve(ValveOptions config);

  /// Keeps a list. One outside the data type or the valve (16,384 entries, ticks below 65,536 and ascending,
  /// pulse and guard between them, pulses from 0.5 ms) is kept as a refusal, as in Robot::add_path. Ticks in
  /// units of tick_s.
  void add_list(const ListName& name, double tick_s, double pulse_s, std::span<const std::int32_t> ticks,
                std::int64_t now_us, Effects& fx);

  /// Done when the microcontroller holds the list, verified.
  void load(const ListName& name, std::int64_t now_us, Effects& fx);
  /// Ready when it waits for the robot's signal. A list that has fired is never armed again.
  void arm(const ListName& name, std::int64_t now_us, Effects& fx);
  /// Ends it. counted = pulses fired of expected: done = all, failed = a prefix, none; unknown [from, to) if
  /// the microcontroller has forgotten. Also after a stop or a lost link: of the list that was armed last.
  void disarm(std::int64_t now_us, Effects& fx);

  bool busy() const override { return op_ != Op::kNone; }
  bool holds(const ListName& name) const { return verified_ && held_ == name; }
  const fvb::Status& status() const { return status_; }

 private:
  enum class Op : std::uint8_t { kNone, kLoad, kArm, kDisarm };
  enum class Phase : std::uint8_t {
    kDown,
    kHello,  // valve closed, count read, list thrown away
    kReady,
    kLoading,
    kArming,
    kArmed,    // until disarmed, also while it fires
    kEnding,   // disarm: the last pulses are awaited
    kClosing,  // DISARM and the count
  };
  using Ticks = std::shared_ptr<const std::vector<std::uint16_t>>;
  struct Kept {
    Ticks ticks;
    std::uint16_t tick_us = 0, pulse_us = 0;
    Violation refusal;
  };
  /// The list armed last, until a disarm has reported its count.
  struct Armed {
    ListName name;
    std::uint32_t id = 0;
    std::int64_t entries = 0;
    std::int64_t last_us = 0;  ///< time of its last pulse
    std::int64_t fired = 0;    ///< known so far
    bool over = false;         ///< disarmed: `fired` is final
    bool doubt = false;        ///< the microcontroller was reset meanwhile
    bool told_disarmed = false;
  };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kHello || phase_ == Phase::kClosing; }

  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;
  bool accept(std::initializer_list<Phase> phases, Effects& fx);
  const Kept* usable(const ListName& name, Effects& fx);
  void refuse(std::int32_t code, std::string text, Effects& fx, const Figure& figure = {});
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);
  void tell_count(std::int32_t code, std::string text, Effects& fx);
  void end_list(bool doubt);
  void close_valve(std::int64_t now_us, Effects& fx);
  void closed_now(Effects& fx);
  bool upload_step();
  bool choose_upload();
  void upload_refused(std::string_view why, bool again, Effects& fx);
  void forget_list();
  void check_armed(const fvb::Status& status, Effects& fx);
  void take_status(const fvb::Status& status, Effects& fx);
  void rebooted(std::int64_t now_us, Effects& fx);

  std::uint8_t seq() { return seq_ = fvb::next_seq(seq_); }
  void ask_status() { link_.push(fvb::request(fvb::Type::kStatus, seq(), {}, Repeat::kRead)); }

  std::string name_;  // for texts
  ValveOptions config_;
  fvb::FvbDialect dialect_;
  fvb::Hello firmware_;  // as it said of itself
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  std::uint8_t seq_ = 0;
  ListName wanted_;
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
  std::int64_t give_up_us_ = 0;  // kEnding

  std::map<ListName, Kept> lists_;
  std::optional<Armed> armed_;
  ListName last_;  // armed last: older ones are over

  // Contents of the microcontroller.
  std::optional<ListName> held_;
  Ticks ticks_;           // of held_: the dialect writes from it
  std::uint32_t id_ = 0;  // of held_, on the wire
  std::uint32_t last_id_ = 0;
  std::size_t sent_ = 0;
  bool begun_ = false, verified_ = false;
  int tries_ = 0;
  std::int32_t boot_count_ = -1;
  fvb::Status status_;
};

}  // namespace firn::drivers
