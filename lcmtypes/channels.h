// The one table of nodes and channels. Everything that needs to know a channel reads it here: senders and
// receivers (typed), transport, recorder, replay, `firn log`, docs/dataflow.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace firn {

class height_map_t;
class height_profile_t;
class scan_done_t;
class layer_plan_t;
class stage_command_t;
class jet_command_t;
class profiler_command_t;
class lamp_command_t;
class answer_t;
class device_state_t;
class deposition_report_t;
class layer_metrics_t;
class fault_t;
class safe_stop_t;
class enable_t;
class run_start_t;
class run_end_t;
class config_t;
class heartbeat_t;
class resend_request_t;
class journal_t;
class preview_t;
class sim_truth_t;
class operator_command_t;
class material_map_t;
class pass_detail_t;
class height_model_t;
class trajectory_t;
class path_job_t;
class pulse_list_t;
class path_report_t;
class robot_command_t;
class valve_command_t;
class laser_command_t;
class laser_samples_t;
class heater_command_t;
class temperature_t;
class control_surface_t;
class flow_model_t;

enum class NodeId : std::uint8_t {
  kScheduler,
  kSurfaceMapper,
  kController,
  kStage,
  kJet,
  kLaserProfiler,
  kLamp,
  kJetB,  // nodes: replayed
  kSafety,
  kDropletEstimator,
  kRobot,
  kValveA,
  kValveB,
  kLaserPoint,
  kHeater,
  kPathPlanner,
  kFlowEstimator,  // of a path printer
  kRecorder,
  kLauncher,  // outside replay
};
inline constexpr int kNodeCount = 19;
inline constexpr int kReplayedNodeCount = 17;

struct NodeInfo {
  NodeId id;
  std::string_view name;  ///< process, write-ahead file and CONFIG_/FAULT_/HEARTBEAT_ suffix (upper case)
  double longest_step_s;  ///< wall time that one step may take before safety calls the node dead
  bool driver;            ///< talks to an instrument and honours the lease
};
std::span<const NodeInfo> nodes();
const NodeInfo& info(NodeId id);
/// @returns nullptr for an unknown name.
const NodeInfo* find_node(std::string_view name);

enum class Delivery : std::uint8_t {
  kReliable,  ///< every message, in order, once: gaps are asked for again
  kLatest,    ///< only the newest counts; a stale or repeated one is dropped
};

struct ChannelInfo {
  std::string_view name;
  std::string_view type;
  NodeId publisher;
  Delivery delivery;
  double rate_hz;  ///< typical; 0 = on event
  int queue;       ///< receive queue [messages]; 0 = unlimited
  bool logged;
  std::string_view meaning;
  /// False for what only tests, audit and reports may read (SIM_TRUTH) and for what no node reads.
  bool nodes_may_read = true;
};
std::span<const ChannelInfo> channel_table();
/// @returns nullptr for an unknown name.
const ChannelInfo* find_channel(std::string_view name);

/// A channel with its message type: `Outbox::send` and `Node::subscribe` accept no other message.
template <class Message>
struct Channel {
  std::string_view name;
};

namespace channels {
inline constexpr Channel<height_map_t> kHeightMap{"HEIGHT_MAP"};
inline constexpr Channel<height_profile_t> kHeightProfile{"HEIGHT_PROFILE"};
inline constexpr Channel<scan_done_t> kScanDone{"SCAN_DONE"};
inline constexpr Channel<layer_plan_t> kLayerPlan{"LAYER_PLAN"};
inline constexpr Channel<material_map_t> kMaterialMap{"MATERIAL_MAP"};
inline constexpr Channel<stage_command_t> kStageCommand{"STAGE_COMMAND"};
inline constexpr Channel<jet_command_t> kJetCommand{"JET_COMMAND"};
inline constexpr Channel<jet_command_t> kJetBCommand{"JET_B_COMMAND"};
inline constexpr Channel<profiler_command_t> kProfilerCommand{"PROFILER_COMMAND"};
inline constexpr Channel<lamp_command_t> kLampCommand{"LAMP_COMMAND"};
inline constexpr Channel<deposition_report_t> kDepositionReport{"DEPOSITION_REPORT"};
inline constexpr Channel<pass_detail_t> kPassDetail{"PASS_DETAIL"};
inline constexpr Channel<height_model_t> kHeightModel{"HEIGHT_MODEL"};
inline constexpr Channel<trajectory_t> kTrajectory{"TRAJECTORY"};
inline constexpr Channel<pulse_list_t> kPulseList{"PULSE_LIST"};
inline constexpr Channel<path_job_t> kPathJob{"PATH_JOB"};
inline constexpr Channel<path_report_t> kPathReport{"PATH_REPORT"};
inline constexpr Channel<robot_command_t> kRobotCommand{"ROBOT_COMMAND"};
inline constexpr Channel<valve_command_t> kValveACommand{"VALVE_A_COMMAND"};
inline constexpr Channel<valve_command_t> kValveBCommand{"VALVE_B_COMMAND"};
inline constexpr Channel<laser_command_t> kLaserCommand{"LASER_COMMAND"};
inline constexpr Channel<laser_samples_t> kLaserSamples{"LASER_SAMPLES"};
inline constexpr Channel<heater_command_t> kHeaterCommand{"HEATER_COMMAND"};
inline constexpr Channel<temperature_t> kTemperature{"TEMPERATURE"};
inline constexpr Channel<control_surface_t> kControlSurface{"CONTROL_SURFACE"};
inline constexpr Channel<flow_model_t> kFlowModel{"FLOW_MODEL"};
inline constexpr Channel<layer_metrics_t> kLayerMetrics{"LAYER_METRICS"};
inline constexpr Channel<preview_t> kHeightPreview{"HEIGHT_PREVIEW"};
inline constexpr Channel<enable_t> kEnable{"ENABLE"};
inline constexpr Channel<safe_stop_t> kSafeStop{"SAFE_STOP"};
inline constexpr Channel<run_start_t> kRunStart{"RUN_START"};
inline constexpr Channel<run_end_t> kRunEnd{"RUN_END"};
inline constexpr Channel<operator_command_t> kOperatorCommand{"OPERATOR_COMMAND"};
inline constexpr Channel<sim_truth_t> kSimTruth{"SIM_TRUTH"};

// One channel per node: ANSWER_STAGE, STATE_JET, FAULT_SAFETY, CONFIG_LAMP, HEARTBEAT_RECORDER, …
Channel<answer_t> answer(NodeId node);              ///< drivers only
Channel<device_state_t> device_state(NodeId node);  ///< drivers only
Channel<fault_t> fault(NodeId node);
Channel<config_t> config(NodeId node);
Channel<heartbeat_t> heartbeat(NodeId node);
Channel<resend_request_t> resend_request(NodeId node);
Channel<journal_t> journal(NodeId node);  ///< replayed nodes only
}  // namespace channels

}  // namespace firn
