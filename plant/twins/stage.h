// StageTwin simulates the stage, an Aerotech Ensemble with three axes, coordinated straight moves and
// position-synchronised output. LINEAR is incremental until ABS. The ASCII dialect is in stage_dialect.h.
// Facts from docs/plant.md, table "stage".
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "plant/config/world_config.h"
#include "plant/twins/motion.h"
#include "plant/twins/path_follower.h"
#include "plant/twins/stage_place.h"
#include "plant/twins/twin.h"

namespace firn::plant {

inline constexpr int kIglobals = 4096;
inline constexpr int kDglobals = 16384;
inline constexpr int kKnotCountIglobal = 40;  ///< read by the program that follows a path [P]
/// The time between two samples of its position [ms], 0 = none; and their number so far, which it writes: x,
/// y of each in DGLOBAL behind the knots [P]
inline constexpr int kSamplePeriodIglobal = 41, kSampleCountIglobal = 42;

/// Position-synchronised output of one axis. Counts travel since ARM, whatever the direction.
struct Pso {
  enum class Mode : std::uint8_t { kNone, kFixed, kArray };
  bool armed = false, output = false, masked = false, window = false;
  bool toggle = false;    ///< each pulse switches the output over instead
  bool vector = false;    ///< counts the way of X and Y together
  bool terminal = false;  ///< PSOOUTPUT CONTROL was given
  Mode mode = Mode::kNone;
  std::int64_t fixed_counts = 0;
  std::vector<std::int64_t> increments;  ///< counts
  double window_low_mm = 0.0, window_high_mm = 0.0;
  std::int64_t next_index = 0;   ///< pulses passed since ARM, masked ones included
  std::int64_t next_counts = 0;  ///< travel of the next pulse; meaningless when exhausted()
  std::int64_t pulses = 0;       ///< put out since ARM
  double travel_mm = 0.0;        ///< since ARM, up to the start of the current move
  bool exhausted() const {
    return !armed || mode == Mode::kNone ||
           (mode == Mode::kArray && next_index >= std::int64_t(increments.size()));
  }
  void arm();
  void advance();
  void io(Archive& a);
};

/// The controller as its interpreter sees it.
class StageDevice final : public StagePlace {
 public:
  StageDevice(const StageParams& params, Wires& wires) : params_(params), wires_(wires) { power_on(); }

  enum class Answer : std::uint8_t { kOk, kNak, kFault };

  // Verbs
  Answer enable(int axis);
  void disable(int axis, std::int64_t now_us);
  void fault_acknowledge(int axis);
  void abort(std::int64_t now_us);
  /// NaN = axis stays. Queued behind the moves in progress, at most 16.
  Answer linear(const Vec3& target_mm, double speed_mm_s, std::int64_t now_us);
  /// The same from where the last move in the queue ends.
  Answer linear_by(const Vec3& step_mm, double speed_mm_s, std::int64_t now_us);
  void set_absolute(bool on) { absolute_ = on; }
  bool absolute() const { return absolute_; }
  /// Runs or stops the homing program, which homes the axis of IGLOBAL(33).
  Answer home_by_program(std::int64_t now_us);
  void stop_program(std::int64_t now_us);
  int task_state() const;  ///< of the homing program: 1 idle, 3 runs, 6 ended with an error
  void break_program(bool on) { program_breaks_ = on; }
  /// Runs the program that moves X and Y through the knots in DGLOBAL: time, x, y, vx, vy of each, as many as
  /// IGLOBAL(40) says.
  Answer follow_path(std::int64_t now_us);
  std::optional<double> parameter(int axis, int number) const;
  Answer home(unsigned axes, std::int64_t now_us);
  bool set_ramp(double rate_mm_s2);
  bool set_scurve(double percent);
  Answer arm(int axis, std::int64_t now_us);
  void pso_off(int axis, std::int64_t now_us);

  // Questions
  Vec3 position_mm(std::int64_t now_us) const override;
  Vec3 feedback_mm(std::int64_t now_us) const;  ///< as the encoders report it
  double velocity_mm_s(int axis, std::int64_t now_us) const override;
  std::uint32_t axis_status(int axis, std::int64_t now_us) const;
  std::uint32_t axis_fault(int axis) const { return faults_[axis]; }
  bool moving() const { return move_.has_value() || track_.has_value(); }
  std::int64_t encoder_counts(int axis, double position_mm) const override;
  Pso& pso(int axis) { return pso_[axis]; }
  std::array<double, kIglobals>& iglobals() { return iglobals_; }
  std::vector<double>& dglobals() { return dglobals_; }
  const StageParams& params() const { return params_; }
  void record_samples(std::int64_t now_us);  ///< up to now, into DGLOBAL

  // Time
  std::int64_t next_us() const;
  void event(std::int64_t now_us);           ///< a pulse or the end of a move
  void link_lost(std::int64_t now_us);       ///< the controller's own watchdog
  void trip(bool on, std::int64_t now_us);   ///< emergency stop input
  void lose_count();                         ///< pulse counters return to zero; homing and motion stay
  void stick(bool on, std::int64_t now_us);  ///< X stands still, whatever it is told
  void drag(bool on, std::int64_t now_us);   ///< X falls behind along a path
  void stick_encoder(bool on, std::int64_t now_us);  ///< X's position feedback stays as it is
  void refuse_enable(bool on) { refuses_enable_ = on; }
  void cross_encoder(bool on) { crossed_ = on; }
  bool encoder_crossed() const override { return crossed_; }
  void mute_pulses(bool on) { mute_ = on; }    ///< pulses are due and none is put out or counted
  void jam_shutter(bool on) { jammed_ = on; }  ///< it stays as it is, whatever the output says
  bool shutter_jammed() const { return jammed_; }
  void power_on();
  void io(Archive& a);

 private:
  struct Target {
    Vec3 mm{};
    double speed_mm_s = 0.0;
    std::uint32_t axes = 0;
    std::uint32_t homing = 0;
  };
  struct NextPulse {
    std::int64_t t_us = kNever;
    int axis = 0;
    double s_mm = 0.0;
  };
  void begin_next(std::int64_t now_us);
  void put_out_pulse(std::int64_t now_us);
  void end_track(std::int64_t now_us);
  void leave_track(std::int64_t now_us);
  void end_move();
  void brake(std::int64_t now_us);
  void raise(int axis, std::uint32_t bits, std::int64_t now_us);
  void find_pulse();
  void find_switch();

  StageParams params_;
  Wires& wires_;
  Vec3 at_mm_{};  ///< while nothing moves
  std::optional<Move> move_;
  std::optional<PathFollower> track_;  ///< in place of a move
  Target current_;
  std::deque<Target> queue_;
  std::array<bool, 3> enabled_{}, homed_{};
  std::array<std::uint32_t, 3> faults_{};
  bool tripped_ = false, stuck_ = false, refuses_enable_ = false, mute_ = false, crossed_ = false,
       jammed_ = false, program_breaks_ = false, program_broken_ = false;
  bool absolute_ = false, drags_ = false;
  std::optional<double> frozen_x_mm_;  ///< of a stuck encoder
  std::int64_t in_position_us_ = 0;
  double sample_period_us_ = 0.0;   ///< 0: nothing is recorded
  std::uint32_t sample_first_ = 0;  ///< its DGLOBAL
  double ramp_mm_s2_ = 0.0, scurve_percent_ = 0.0;
  std::array<Pso, 3> pso_{};
  NextPulse next_pulse_;
  std::array<double, kIglobals> iglobals_{};
  std::vector<double> dglobals_ = std::vector<double>(kDglobals);
};

/// The device behind its port.
class StageTwin : public Twin {
 public:
  StageTwin(const StageParams& params, Wires& wires);
  void connected(std::int64_t now_us) override { last_heard_us_ = now_us; }
  void disconnected(std::int64_t now_us) override;
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;
  bool device_event_replies() const override { return blocked_ || idle_close_us() != kNever; }
  void reboot(std::int64_t now_us) override;
  /// 0: mended. 1: emergency stop. 2: the pulse counters return to zero, and no status bit tells of it. 3: X
  /// is stuck. 4: no axis enables. 5: no pulses are put out. 7: the shutter is stuck. 8: the homing
  /// program ends with an error. 9: X drags along a path. 10: X's encoder is stuck.
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override;
  StageDevice& device() { return device_; }

 private:
  void interpret(std::int64_t now_us);
  std::int64_t idle_close_us() const;

  StageDevice device_;
  Wires& wires_;
  std::string line_;             ///< bytes not interpreted yet
  bool wait_for_motion_ = true;  ///< WAIT MODE; the power-on mode blocks the interpreter during a move
  bool blocked_ = false;         ///< a move was acknowledged to nobody yet
  std::int64_t last_heard_us_ = 0;
};

}  // namespace firn::plant
