#include "lcmtypes/channels.h"

#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {
namespace {

using enum NodeId;
using enum Delivery;

constexpr std::array<NodeInfo, kNodeCount> kNodes{{
    {kScheduler, "scheduler", 2.0, false},
    {kSurfaceMapper, "surface_mapper", 5.0, false},
    {kController, "controller", 60.0, false},
    {kStage, "stage", 2.0, true},
    {kJet, "jet", 2.0, true},
    {kLaserProfiler, "laser_profiler", 2.0, true},
    {kLamp, "lamp", 2.0, true},
    {kJetB, "jet_b", 2.0, true},
    {kSafety, "safety", 0.3, false},
    {kDropletEstimator, "droplet_estimator", 60.0, false},
    {kRobot, "robot", 2.0, true},
    {kValveA, "valve_a", 2.0, true},
    {kValveB, "valve_b", 2.0, true},
    {kLaserPoint, "laser_point", 2.0, true},
    {kHeater, "heater", 2.0, true},
    {kPathPlanner, "path_planner", 60.0, false},
    {kFlowEstimator, "flow_estimator", 60.0, false},
    {kRecorder, "recorder", 5.0, false},
    {kLauncher, "launcher", 5.0, false},
}};

constexpr ChannelInfo kShared[] = {
    {"HEIGHT_MAP", "height_map_t", kSurfaceMapper, kReliable, 0, 0, true,
     "measured surface after a layer: the request"},
    {"HEIGHT_PROFILE", "height_profile_t", kLaserProfiler, kReliable, 0, 0, true,
     "one line of the laser profiler"},
    {"SCAN_DONE", "scan_done_t", kLaserProfiler, kReliable, 0, 0, true, "a scan is complete"},
    {"LAYER_PLAN", "layer_plan_t", kController, kReliable, 0, 0, true,
     "droplets of the next layer: the answer"},
    {"MATERIAL_MAP", "material_map_t", kController, kReliable, 0, 0, true,
     "two inks: which cell of the layer is of which"},
    {"STAGE_COMMAND", "stage_command_t", kScheduler, kReliable, 0, 0, true, "raster pass, scan, move, home"},
    {"JET_COMMAND", "jet_command_t", kScheduler, kReliable, 0, 0, true, "arm, disarm and count"},
    {"JET_B_COMMAND", "jet_command_t", kScheduler, kReliable, 0, 0, true, "the same for the jet of ink B"},
    {"PROFILER_COMMAND", "profiler_command_t", kScheduler, kReliable, 0, 0, true, "arm for a scan, end it"},
    {"LAMP_COMMAND", "lamp_command_t", kScheduler, kReliable, 0, 0, true, "timed exposure"},
    {"DEPOSITION_REPORT", "deposition_report_t", kScheduler, kReliable, 0, 0, true,
     "what is known of one pass"},
    {"PASS_DETAIL", "pass_detail_t", kScheduler, kReliable, 0, 0, true,
     "ink and sub-pattern of the pass that is reported next"},
    {"HEIGHT_MODEL", "height_model_t", kDropletEstimator, kReliable, 0, 0, true,
     "what droplets add, learned from the layers so far"},
    {"TRAJECTORY", "trajectory_t", kPathPlanner, kReliable, 0, 0, true,
     "where the arm is along one path, tick by tick"},
    {"PULSE_LIST", "pulse_list_t", kPathPlanner, kReliable, 0, 0, true, "when a valve opens along one path"},
    {"PATH_JOB", "path_job_t", kPathPlanner, kReliable, 0, 0, true, "the paths that are run next, in order"},
    {"PATH_REPORT", "path_report_t", kScheduler, kReliable, 0, 0, true,
     "what is known of one path that was run"},
    {"ROBOT_COMMAND", "robot_command_t", kScheduler, kReliable, 0, 0, true,
     "home, load a path, run it, move"},
    {"VALVE_A_COMMAND", "valve_command_t", kScheduler, kReliable, 0, 0, true,
     "load a pulse list, arm, disarm and count"},
    {"VALVE_B_COMMAND", "valve_command_t", kScheduler, kReliable, 0, 0, true,
     "the same for the scaffold's valve"},
    {"LASER_COMMAND", "laser_command_t", kScheduler, kReliable, 0, 0, true,
     "arm the storage of readings, read it out"},
    {"LASER_SAMPLES", "laser_samples_t", kLaserPoint, kReliable, 0, 0, true, "readings along one path"},
    {"HEATER_COMMAND", "heater_command_t", kScheduler, kReliable, 0, 0, true, "set points"},
    {"TEMPERATURE", "temperature_t", kHeater, kReliable, 1, 0, true, "of the end effector"},
    {"CONTROL_SURFACE", "control_surface_t", kController, kReliable, 0, 0, true,
     "more or less than nominal, over the part: the answer to a map"},
    {"FLOW_MODEL", "flow_model_t", kFlowEstimator, kReliable, 0, 0, true,
     "what the valves give against their calibration"},
    {"LAYER_METRICS", "layer_metrics_t", kScheduler, kReliable, 0, 0, true,
     "health of the print, one per layer"},
    {"HEIGHT_PREVIEW", "preview_t", kSurfaceMapper, kLatest, 0, 1, false, "reduced height map for lcm-spy",
     false},
    {"ENABLE", "enable_t", kSafety, kLatest, 20, 1, true, "the lease of the drivers"},
    {"SAFE_STOP", "safe_stop_t", kSafety, kLatest, 0, 1, true,
     "raises the enable epoch; repeated until all are safe"},
    {"RUN_START", "run_start_t", kLauncher, kReliable, 0, 0, true, "all processes are ready"},
    {"RUN_END", "run_end_t", kScheduler, kReliable, 0, 0, true, "the scheduler has nothing left to do"},
    {"OPERATOR_COMMAND", "operator_command_t", kLauncher, kReliable, 0, 0, true,
     "what only a person may decide"},
    {"SIM_TRUTH", "sim_truth_t", kLauncher, kReliable, 0, 0, true, "what the simulated world knows", false},
};

struct PerNode {
  std::string_view prefix, type;
  Delivery delivery;
  double rate_hz;
  int queue;
  bool logged;
  std::string_view meaning;
  bool nodes_may_read;
  bool (*applies)(const NodeInfo&);
};
constexpr auto kAny = [](const NodeInfo&) { return true; };
constexpr auto kDrivers = [](const NodeInfo& n) { return n.driver; };
constexpr auto kReplayed = [](const NodeInfo& n) { return int(n.id) < kReplayedNodeCount; };

constexpr PerNode kFamilies[] = {
    {"ANSWER_", "answer_t", kReliable, 0, 0, true, "answer to a command", true, kDrivers},
    {"STATE_", "device_state_t", kReliable, 0, 0, true, "state of instrument and link", true, kDrivers},
    {"FAULT_", "fault_t", kReliable, 0, 0, true, "what went wrong", true, kAny},
    {"CONFIG_", "config_t", kReliable, 0, 0, true, "resolved configuration and commit, first message", false,
     kReplayed},
    {"HEARTBEAT_", "heartbeat_t", kLatest, 10, 1, true,
     "runner's own thread: alive, busy since, last sequence numbers", true, kAny},
    {"RESEND_", "resend_request_t", kLatest, 0, 0, false, "transport: asks for lost messages again", false,
     kAny},
    {"JOURNAL_", "journal_t", kLatest, 0, 1, false, "summary of one step for lcm-spy", false, kReplayed},
};

std::string channel_name(std::string_view prefix, std::string_view node) {
  std::string name(prefix);
  for (char c : node) name += c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
  return name;
}

struct Table {
  std::deque<std::string> names;  // stable addresses for the string_views below
  std::vector<ChannelInfo> rows;

  Table() {
    rows.assign(std::begin(kShared), std::end(kShared));
    for (const PerNode& f : kFamilies)
      for (const NodeInfo& n : kNodes)
        if (f.applies(n)) {
          names.push_back(channel_name(f.prefix, n.name));
          rows.push_back({names.back(), f.type, n.id, f.delivery, f.rate_hz, f.queue, f.logged, f.meaning,
                          f.nodes_may_read});
        }
  }
};

const Table& table() {
  static const Table t;
  return t;
}

template <class M>
Channel<M> member(std::string_view prefix, NodeId node) {
  const std::string name = channel_name(prefix, info(node).name);
  const ChannelInfo* row = find_channel(name);
  if (!row) throw std::logic_error("no channel " + name);
  return {row->name};
}

}  // namespace

std::span<const NodeInfo> nodes() { return kNodes; }
const NodeInfo& info(NodeId id) { return kNodes[std::size_t(id)]; }

const NodeInfo* find_node(std::string_view name) {
  for (const NodeInfo& n : kNodes)
    if (n.name == name) return &n;
  return nullptr;
}

std::span<const ChannelInfo> channel_table() { return table().rows; }

const ChannelInfo* find_channel(std::string_view name) {
  for (const ChannelInfo& c : table().rows)
    if (c.name == name) return &c;
  return nullptr;
}

namespace channels {
Channel<answer_t> answer(NodeId n) { return member<answer_t>("ANSWER_", n); }
Channel<device_state_t> device_state(NodeId n) { return member<device_state_t>("STATE_", n); }
Channel<fault_t> fault(NodeId n) { return member<fault_t>("FAULT_", n); }
Channel<config_t> config(NodeId n) { return member<config_t>("CONFIG_", n); }
Channel<heartbeat_t> heartbeat(NodeId n) { return member<heartbeat_t>("HEARTBEAT_", n); }
Channel<resend_request_t> resend_request(NodeId n) { return member<resend_request_t>("RESEND_", n); }
Channel<journal_t> journal(NodeId n) { return member<journal_t>("JOURNAL_", n); }
}  // namespace channels

}  // namespace firn
