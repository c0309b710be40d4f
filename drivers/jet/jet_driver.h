// JetDriver holds the common part of all kinds of jets: the commands of a print and how they end, and a
// person's orders, whose values are held against the limits of the kind. JetTraits tells of each kind what
// the node, bring-up and calibrations must know.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/jet/jet_config.h"
#include "drivers/jet/jet_interface.h"

namespace firn::drivers {

struct JetOptions : JetConfig {
  int drops_per_trigger = 1;
  bool strobe = true;
  double poll_idle_s = 2.0;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

class JetDriver;

struct JetTraits {
  std::string_view instrument;  ///< as bring-up calls it: "a MicroFab jet"
  std::unique_ptr<JetDriver> (*make)(const JetOptions&);
  std::vector<Request> (*questions)();       ///< that change nothing: who answers at a port
  bool (*answers)(std::string_view heard);   ///< to one of them
  bool trigger_by_words = false;             ///< it is armed by jet.trigger_on, which the lab must know
  bool two_sizes = false;                    ///< of droplets, by a second waveform
  bool second_pulse = true;                  ///< echo_v for echo_us
  double min_v = -kMaxJet_v, step_us = 0.1;  ///< of the first pulse
  int max_divider = 255;                     ///< droplets of one flash
  double most_drops = std::numeric_limits<double>::infinity();  ///< of one order "continuous"
};

template <class Kind>
std::unique_ptr<JetDriver> new_jet(const JetOptions& config) {
  return std::make_unique<Kind>(config);
}

/// Returns whether the reply answers the dialect's harmless question.
bool answers_probe(const Dialect& dialect, std::string_view heard);

/// The row of a kind in drivers/jet/jet_kinds.cpp.
const JetTraits& traits_of(JetKind kind);
/// Why a jet with these settings cannot be armed; "": it can.
std::string unarmable(const JetConfig& config);

/// The values of the order "waveform".
struct JetPulses {
  double dwell_v = 0.0, echo_v = 0.0, dwell_us = 0.0, echo_us = 0.0;
};
/// Why a jet with this configuration refuses them, with value and limit; "": it takes them.
std::string refusal_of(const JetPulses& pulses, const JetConfig& config);
/// Why a jet with this configuration makes no small droplets; "": it does.
std::string small_refusal(const JetConfig& config);

class JetDriver : public JetInterface {
 public:
  void arm(std::int64_t expected, std::int64_t now_us, Effects& fx) final {
    arm(expected, false, now_us, fx);
  }
  void arm_small(std::int64_t expected, std::int64_t now_us, Effects& fx) final {
    arm(expected, true, now_us, fx);
  }
  void disarm(std::int64_t now_us, Effects& fx) override;
  /// At most dialect.most_continuous_s.
  void jet(std::int64_t now_us, Effects& fx) override;
  bool busy() const override { return op_ != Op::kNone; }

 protected:
  enum class Op : std::uint8_t { kNone, kArm, kDisarm, kWaveform, kJet };

  /// @throws std::invalid_argument naming the setting and its range
  JetDriver(const Dialect& dialect, JetKind kind, JetOptions config);

  virtual bool ready() const = 0;    ///< off, and free for a command
  virtual bool at_rest() const = 0;  ///< ready, armed or jetting: nothing is under way
  virtual void start_arming(bool small) = 0;
  virtual void start_disarming(std::int64_t now_us, Effects& fx) { safe_stop(now_us, fx); }
  // A person's orders, within the limits: what is sent at the beginning and at the end.
  virtual void fire(int droplets, Service& s) = 0;
  virtual void jet_for(double seconds, Service& s) = 0;
  virtual void strobe(int divider, int delay_us, Service& s) = 0;
  virtual void pulses(const JetPulses& pulses, Service s, Effects& fx) = 0;
  virtual bool obeyed(const Request& request, std::span<const std::byte> frame) const = 0;
  void stop(std::int64_t now_us, Effects& fx) final;
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us, Effects& fx) final;

  /// @returns whether a command may begin; else it is refused
  bool accepts(bool ready, Effects& fx) const;
  void armed(std::string_view text, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);
  void finish_pass(std::string text, Effects& fx);  ///< of disarm()
  void disarmed_before_its_time(std::int64_t now_us);
  virtual void cease(std::int64_t now_us, Effects& fx) = 0;  ///< no droplet from now on: of a stop
  void give_up(std::int32_t code, const std::string& why, std::int64_t now_us, Effects& fx);
  std::int64_t device_wake_us() const override { return link_.idle() && at_rest() ? poll_at_us() : 0; }
  std::int64_t poll_at_us() const { return link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6); }

  void arm(std::int64_t expected, bool small, std::int64_t now_us, Effects& fx);

  JetOptions config_;
  Op op_ = Op::kNone;
  std::int64_t expected_ = 0;
  bool may_fire_ = false;  ///< from the first byte of arming until the instrument confirms that it is off
  std::int64_t armed_until_us_ = 0;  ///< when a stop disarmed the jet; 0: none did since arm()
  std::string not_armed_;            ///< why the jet may have been disarmed since arm(); empty: it was armed
};

}  // namespace firn::drivers
