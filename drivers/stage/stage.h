// Stage controls an Aerotech Ensemble with position-synchronised output; axes @0 = X, @1 = Y, @2 = Z. The
// pulse output of X fires the jet, or switches the shutter; that of Y triggers the profiler.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/stage/controller_parameters.h"
#include "drivers/stage/pulse_outputs.h"
#include "drivers/stage/stage_driver.h"
#include "drivers/stage/stage_tag.h"

namespace firn::drivers {

/// Where a raster pass stands. Its drops are numbered in firing order.
struct PassProgress {
  std::size_t run = 0;      ///< index of the run in progress
  std::int64_t before = 0;  ///< pulses of the runs before it, all counted
  bool launched = false;    ///< its firing move was handed to the controller
};

class Stage final : public StageDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Stage(StageOptions config);

  void run_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s, std::int64_t now_us,
                Effects& fx, double lead_mm = 0.0, const Placement& placement = {}) override {
    begin_pass(pattern, pass, z_mm, speed_mm_s, lead_mm, placement, now_us, fx);
    pump(now_us, fx);
  }
  void scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
            std::int64_t now_us, Effects& fx) override {
    begin_scan(x_mm, y_mm, z_mm, pitch_mm, rows, speed_mm_s, now_us, fx);
    pump(now_us, fx);
  }
  void move_to(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
               Effects& fx) override {
    begin_move(x_mm, y_mm, z_mm, speed_mm_s, now_us, fx);
    pump(now_us, fx);
  }
  /// With path_sample_s, the controller records its position along the way; the samples are read while it
  /// runs.
  void trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx) override {
    begin_trace(std::move(way), z_mm, now_us, fx);
    pump(now_us, fx);
  }
  void home(std::int64_t now_us, Effects& fx) override {
    begin_home(fx);
    pump(now_us, fx);
  }

  bool busy() const override { return op_ != Op::kNone; }
  const PassProgress& progress() const { return progress_; }
  /// Feedback as last read [mm]; NaN = not read yet.
  double position_mm(int axis) const { return position_mm_[std::size_t(axis)]; }

 private:
  enum class Op : std::uint8_t { kNone, kPass, kScan, kMove, kHome, kTrace };
  enum class Phase : std::uint8_t {
    kDown,      // no link
    kStopping,  // stop burst sent: wait until nothing moves
    kEvidence,  // positions, axis faults and the pulse counter are being read
    kFaultCheck,
    kEnabling,
    kParameters,
    kHoming,
    kRamp,  // initialisation
    kReady,
    kToStart,  // move to the start of a run, or the move of a move command
    kAtStart,  // positions are read and compared
    kArming,
    kSettling,  // a path waits for the in-position bits
    kFiring,
    kCounting,  // one run
    kDead,      // fault or emergency stop: latched until home() or a new connection
  };
  using Tag = stage_tag::Tag;
  using enum stage_tag::Tag;
  struct Doom {
    DeviceState state;
    std::int32_t code;
    std::string text;
  };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kStopping || phase_ == Phase::kEvidence; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  // Commands.
  bool accept(Op op, Effects& fx);
  void begin_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s, double lead_mm,
                  const Placement& placement, std::int64_t now_us, Effects& fx);
  void begin_scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
                  std::int64_t now_us, Effects& fx);
  void begin_move(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us, Effects& fx);
  void begin_home(Effects& fx);
  void begin_trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx);
  void follow(std::int64_t now_us);
  bool settled(std::int64_t now_us, Effects& fx);
  bool read_samples();
  bool read_last_samples();
  void start_operation(std::int64_t now_us, Effects& fx);
  // Link, stopping.
  void begin_stop(std::int64_t now_us, Effects& fx, std::string why, std::int32_t code);
  void send_stop_burst(std::int64_t now_us, Effects& fx, bool urgently);
  void rejected(const Request& request, const ensemble::Reply& reply, std::int64_t now_us, Effects& fx);
  void evidence_complete(std::int64_t now_us, Effects& fx);
  void conclude(std::int64_t now_us, Effects& fx);
  std::optional<PulseRange> pulses_possible() const;
  void finish(Result result, Effects& fx);
  void check_status(int axis, std::uint32_t bits, std::int64_t now_us, Effects& fx);
  // Enabling, the controller's parameters, homing.
  bool initialise(std::int64_t now_us, Effects& fx);
  bool home_next(std::int64_t now_us, Effects& fx);
  void start_homing(int axis, std::int64_t now_us);
  bool check_parameters(std::int64_t now_us, Effects& fx);
  bool give_up(DeviceState state, std::int32_t code, std::string why, std::int64_t now_us, Effects& fx);
  // Runs, moves, polling.
  bool work(std::int64_t now_us, Effects& fx);
  void go_to_start(std::int64_t now_us);
  void push_arming();
  void fire(std::int64_t now_us);
  void count_run(std::int64_t now_us, Effects& fx);
  double z_target_mm() const;
  void move(std::array<double, 3> target_mm, double speed_mm_s, std::int64_t now_us);
  enum class Motion : std::uint8_t { kAsked, kWaiting, kOver };
  enum class Poll : std::uint8_t { kNone, kPlane, kAxes };  // the last question
  Motion poll_motion(std::int64_t now_us);
  Violation off_target() const;
  void read(std::string_view verb, int axis, Tag tag);
  void setup(std::string_view verb, int axis, std::string_view rest, Tag tag = kPlain);
  int pulse_axis() const { return op_ == Op::kScan ? 1 : 0; }

  ensemble::EnsembleDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;

  // The operation in progress.
  std::vector<RasterRun> runs_;
  StageWay way_;
  PassProgress progress_;
  std::int64_t expected_ = 0;
  WayReadout readout_;
  double speed_mm_s_ = 0.0;
  std::array<double, 3> start_mm_{};  // of the scan; target of the move; NaN = axis stays
  double scan_pitch_mm_ = 0.0;
  std::string ending_;  // why it is being stopped
  std::int32_t ending_code_ = kNoCode;
  std::optional<Doom> doom_;  // latched once the stop is over

  // State and settings of the controller.
  ControllerParameters parameters_;
  PulseOutputs outputs_;
  bool absolute_ = false;  // ABS was sent since the connection or the last stop
  std::array<double, 3> position_mm_;
  std::array<double, 3> target_mm_;
  std::array<std::uint32_t, 3> status_{};
  std::array<std::uint32_t, 3> fault_bits_{};
  std::optional<std::int64_t> pulses_;
  bool plane_busy_ = false;
  bool initialised_ = false;  // enabled, homed, ramps set since the connection or the last fault
  bool initialise_after_stop_ = false;
  bool was_homed_ = false;
  std::int64_t triggers_off_us_ = 0;  // when the controller acknowledged that in a stop; 0: it did not yet
  bool restarted_ = false;  // the controller lost its home: it is not the one that counted our pulses

  int axis_ = 0;               // of the initialisation step
  bool asked_ = false;         // the reads of this initialisation step were queued
  bool acknowledged_ = false;  // FAULTACK was sent for axis_
  Poll poll_ = Poll::kNone;
  std::int64_t poll_at_us_ = 0;
  int home_polls_ = 0;  ///< of the axis that homes
  std::int64_t move_end_us_ = 0;
  std::int64_t move_limit_us_ = 0;
};

}  // namespace firn::drivers
