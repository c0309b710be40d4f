// Robot controls the Cobra 600 behind FVP/1. It holds trajectories, uploads them ahead of time into the
// controller's two slots, goes to a path's first point, runs it with signals for valves and laser, and says
// how long it took. Joints only: rad, rad, mm (up), rad; who plans knows the tool.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/link/driver.h"
#include "drivers/robot/fvp.h"
#include "drivers/robot/robot_config.h"
#include "drivers/robot/robot_paths.h"
#include "drivers/robot/robot_tag.h"

namespace firn::drivers {

struct JointLimit {
  double low = 0.0;  ///< rad or mm
  double high = 0.0;
  double max_rate = 0.0;   ///< of a path, from one point to the next [rad/s, mm/s]
  double move_rate = 0.0;  ///< of a move at 100 percent
};

struct RobotOptions : RobotConfig {
  std::array<JointLimit, 4> limits;  ///< default: Table 2-1 of the thesis
  double tick_s = 0.016;
  bool upload_ahead = true;
  double slip_s = 0.016;                     ///< interlock 7
  double stall_factor = 1.1, stall_s = 0.5;  ///< interlock 5
  double host_latency_s = 0.0;               ///< see Dialect::allow_host_latency
  RobotOptions();
};

/// Of RobotCommand::signals and `PATH RUN`.
enum Signal : int { kSignalValveA = 1, kSignalValveB = 2, kSignalLaser = 4 };

class Robot final : public Driver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Robot(RobotOptions config);

  /// Keeps a trajectory: row-major, 4 axes. One that breaks a joint limit, a rate or the tick is kept only as
  /// a refusal, which every command for it gets (interlock 8); the fault says so at once. A known number is
  /// left as it is.
  void add_path(std::int64_t path, double tick_s, int axes, std::span<const double> positions,
                std::int64_t now_us, Effects& fx);

  /// The operator's resume: a fault or an emergency stop that is found at the next look round, which a new
  /// connection begins, is cleared, once, if its cause is gone; arm power stays as it is and nothing moves.
  /// Any later one latches again.
  void permit_reset() override { reset_permitted_ = true; }

  // Commands, accepted or refused as those of Stage.
  /// Done when the robot holds the part, verified. Most often it does already.
  void load(const PathPart& part, std::int64_t now_us, Effects& fx);
  /// Goes to the first point, then runs. Result: done, counted = measured, expected = planned microseconds;
  /// failed: counted = how far it came; none: nothing of the path was run; unknown: [from, to) microseconds
  /// of it may have been. A part that was started with a valve's signal is never started again.
  void run(const PathPart& part, int signals, std::int64_t now_us, Effects& fx);
  /// Raises, turns, lowers. Percent of full speed, 0 = approach_percent.
  void move_to(const fvp::Joints& target, int percent, std::int64_t now_us, Effects& fx);
  /// Resets, power, monitor speed, calibration, then up to home_z_mm. The operator's reset after a fault.
  void home(std::int64_t now_us, Effects& fx);
  void drop(std::int64_t path, std::int64_t now_us, Effects& fx);
  /// A command that its caller found to be impossible, and why.
  void decline(const std::string& why, std::int64_t now_us, Effects& fx);

  bool busy() const override { return op_ != Op::kNone; }
  std::optional<fvp::Joints> joints() const;  ///< where it last said that it stands
  const fvp::Status& status() const { return status_; }
  bool holds(const PathPart& part) const { return paths_.holds(part); }

 private:
  enum class Op : std::uint8_t { kNone, kLoad, kRun, kMove, kHome };
  enum class Phase : std::uint8_t {
    kDown,
    kHello,
    kStopping,  // until it stands; evidence; raise
    kReady,
    kLoading,  // the part that a command waits for
    kMoving,   // the moves of a list: approach, move, homing's last
    kStarting,
    kRunning,
    kHoming,
    kDead,  // fault or emergency stop: until home() or a new connection
  };
  using Tag = robot_tag::Tag;
  using enum robot_tag::Tag;
  enum class Motion : std::uint8_t { kAsked, kWaiting, kOver };
  struct Target {
    bool only_z = false;
    fvp::Counts counts{};
    int percent = 0;
  };
  struct Doom {
    DeviceState state;
    std::int32_t code;
    std::string text;
  };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void unsolicited(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  void tick(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kStopping || phase_ == Phase::kHello; }

  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;
  void jog(std::span<const double> values, std::int64_t now_us, Effects& fx);

  // Commands.
  bool accept(Op op, Effects& fx);
  bool runnable(const PathPart& part, Effects& fx);
  void refuse(std::int32_t code, std::string text, Effects& fx, const Figure& figure = {});
  void finish(Result result, Effects& fx);
  // Link, stopping, result of an interrupted command.
  void begin_stop(std::int64_t now_us, Effects& fx, std::string why, std::int32_t code);
  bool stopping_step(std::int64_t now_us, Effects& fx);
  void conclude(Effects& fx);
  void refused(const Request& request, int code, std::string_view text, std::int64_t now_us, Effects& fx);
  void take_status(const fvp::Status& status, std::int64_t now_us, Effects& fx);
  std::optional<Doom> latched() const;
  void die(Effects& fx);
  void ready(std::string_view text, Effects& fx);
  // Moves, homing, running a path.
  bool homing_step(std::int64_t now_us, Effects& fx);
  void begin_way();
  void plan_way(const fvp::Counts& to, int percent);
  bool moving_step(std::int64_t now_us, Effects& fx);
  Motion motion(std::int64_t now_us);
  void start_move(const Target& target, std::int64_t now_us);
  void start_path(std::int64_t now_us, Effects& fx);
  bool running_step(std::int64_t now_us, Effects& fx);
  void complete_run(Effects& fx);
  std::int64_t planned_us() const;
  // Upload of paths.
  bool upload_step();
  void upload_refused(std::string_view why, Effects& fx);

  std::int64_t seq() { return seq_ = fvp::next_seq(seq_); }
  void push(LineWriter line, Repeat repeat, Tag tag) { link_.push(fvp::to_request(line, seq_, repeat, tag)); }
  void ask(std::string_view verb, Tag tag) { push(fvp::request(seq(), verb), Repeat::kRead, tag); }
  void order(std::string_view verb, Tag tag = kPlain) {
    push(fvp::request(seq(), verb), Repeat::kSetup, tag);
  }

  RobotOptions config_;
  int approach_percent_ = 0;  // of full speed, on the way to a path's first point
  fvp::FvpDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  std::int64_t seq_ = 0;
  RobotPaths paths_{dialect_, link_, seq_};

  // The command in progress.
  PathPart part_;
  int signals_ = 0;
  std::size_t part_points_ = 0;
  fvp::Counts first_point_{}, last_point_{};
  std::int32_t run_id_ = 0;
  bool launched_ = false;  // PATH RUN left for it
  bool path_over_ = false;
  std::int32_t took_ms_ = 0;
  std::vector<Target> way_;
  std::size_t way_at_ = 0;
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
  std::optional<Doom> doom_;

  // The robot's status.
  fvp::Status status_;
  std::int32_t boot_count_ = -1;
  bool restarted_ = false;
  bool reset_permitted_ = false;
  std::optional<fvp::Counts> where_;
  std::optional<fvp::Counts> commanded_;  // where it was sent last, as long as it stands there
  bool low_ = false;                      // the tool may be at the part
  bool move_over_ = false;
  int slips_ = 0;  // in a row
  int step_ = 0;   // of stopping and homing
  std::int64_t poll_at_us_ = 0;
  std::int64_t limit_us_ = 0;  // of the motion under way
};

}  // namespace firn::drivers
