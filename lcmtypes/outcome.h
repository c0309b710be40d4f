// Meanings of the small numbers in messages, for all who write or read them.
#pragma once

#include <cstdint>

namespace firn {

/// answer_t.outcome, deposition_report_t.outcome
enum class Outcome : std::int8_t {
  kReady = 0,
  kDone = 1,
  kNone = 2,
  kUnknown = 3,
  kRefused = 4,
  kFailed = 5
};

/// device_state_t.state
enum class DeviceState : std::int8_t {
  kDisconnected = 0,
  kConnecting = 1,
  kIdentifying = 2,
  kSafe = 3,
  kStaged = 4,
  kArmed = 5,
  kActive = 6,
  kSuspect = 7,
  kFault = 8,
  kEstop = 9,
};

/// layer_plan_t.decision
enum class PlanDecision : std::int8_t { kPrint = 0, kEnd = 1, kStop = 2 };

/// run_end_t.outcome. kOutOfTolerance: all layers are printed, and the last map says that the part is not
/// what was wanted.
enum class RunOutcome : std::int8_t {
  kFinished = 0,
  kEndedEarly = 1,
  kStoppedSafely = 2,
  kWaitsForOperator = 3,
  kOutOfTolerance = 4
};

/// fault_t.severity
enum class Severity : std::int8_t { kNotice = 0, kWarning = 1, kStop = 2 };

enum class StageVerb : std::int8_t { kPass = 1, kScan = 2, kMove = 3, kHome = 4 };
enum class JetVerb : std::int8_t { kArm = 1, kDisarm = 2 };
enum class ProfilerVerb : std::int8_t { kArm = 1, kEnd = 2 };
enum class LampVerb : std::int8_t { kExpose = 1 };
enum class OperatorVerb : std::int8_t { kAcceptDoubt = 1 };

enum class RobotVerb : std::int8_t { kHome = 1, kLoad = 2, kRun = 3, kMove = 4, kDrop = 5 };
enum class ValveVerb : std::int8_t { kLoad = 1, kArm = 2, kDisarm = 3 };
enum class LaserVerb : std::int8_t { kArm = 1, kCollect = 2, kReading = 3 };
enum class HeaterVerb : std::int8_t { kSet = 1 };
/// robot_command_t.signals
enum RobotSignal : std::int32_t { kSignalValveA = 1, kSignalValveB = 2, kSignalLaser = 4 };
/// robot_command_t.tool
enum class RobotTool : std::int8_t { kFlange = 0, kNozzleA = 1, kNozzleB = 2, kLaser = 3 };
/// path_job_t.valve, pulse_list_t.valve
enum class Valve : std::int8_t { kNone = 0, kA = 1, kB = 2 };
/// control_surface_t.version
enum class ControlVersion : std::int8_t { kPathSpeed = 0, kValveFrequency = 1 };

/// height_map_t.quality
enum class CellQuality : std::int8_t { kMeasured = 0, kInFilled = 1, kOutlierReplaced = 2 };

}  // namespace firn
