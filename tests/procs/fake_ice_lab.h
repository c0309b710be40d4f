// FakeIceLab simulates an ice lab for the scheduler's tests, without instruments: it plans, answers commands
// truthfully, counts every pulse, and can crash in the middle of any command.
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/slice/paths/print_paths.h"
#include "firn/fault_t.hpp"
#include "firn/heater_command_t.hpp"
#include "firn/laser_command_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/valve_command_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/path_loop.h"
#include "tests/support/node_bench.h"

namespace firn::test {

inline Experiment small_ice(const std::string& scheme = "smf") {
  Experiment e;
  e.lab.kind = "ice";
  e.control.scheme = scheme;
  e.ice.interval_layers = 2;
  e.process.max_rescans = 1;
  return e;
}

// A square of 10 mm in `layers` layers.
inline slice::PrintPaths square_paths(int layers) {
  slice::PrintPaths p;
  p.head.materials = {{"part", "water"}, {"scaffold", "scaffold"}};
  for (int n = 1; n <= layers; ++n) {
    slice::LayerPaths l;
    l.layer = n;
    l.height = 2400;
    l.z = n * 2400;
    const geometry::Point corners[] = {{0, 0}, {100000, 0}, {100000, 100000}, {0, 100000}};
    l.lines.add(corners);
    l.info.push_back({PathKind::kBoundary, 0, true, 15000});
    if (n % 2 == 0) {
      l.lines.add(corners);
      l.info.push_back({PathKind::kMeasurement, 0, true, 0});
    }
    p.layers.push_back(l);
  }
  return p;
}

struct FakeIceLab : NodeBench {
  FakeIceLab(std::uint64_t seed, const Experiment& e, int layers = 6)
      : NodeBench(NodeId::kScheduler, std::make_unique<PathLoop>(e, square_paths(layers), 0.016)),
        random(seed, Purpose::kTest),
        experiment(e),
        layers(layers) {}

  void begin(std::int32_t incarnation) {
    start(incarnation);
    ++epoch;
    if (unanswered) {
      const answer_t late = *unanswered;
      unanswered.reset();
      give(channels::answer(late_driver), late);
    }
    for (NodeId d :
         {NodeId::kRobot, NodeId::kValveA, NodeId::kValveB, NodeId::kLaserPoint, NodeId::kHeater}) {
      device_state_t s{};
      s.node = info(d).name;
      s.state = std::int8_t(DeviceState::kSafe);
      give(channels::device_state(d), s);
    }
    enable_t lease{};
    lease.enable_epoch = epoch;
    lease.enabled = 1;
    lease.lease_s = 0.3;
    give(channels::kEnable, lease);
    if (incarnation == 0) plan(0);
    warm(20.0);
  }

  void warm(double tip_degC, int fault_a = 0, int fault_b = 0) {
    temperature_t t{};
    t.degC[0] = t.degC[1] = t.degC[2] = tip_degC;
    t.fault[0] = std::int8_t(fault_a);
    t.fault[1] = std::int8_t(fault_b);
    give(channels::kTemperature, t);
  }

  // The paths of the next interval, jobs and lists in any order.
  void plan(std::int64_t map_id) {
    const bool table = map_id == 0 && experiment.ice.map_table == "on";
    const int first = done_layers + 1,
              last = table ? 0 : std::min(layers, done_layers + experiment.ice.interval_layers);
    std::vector<path_job_t> jobs;
    ++batch;
    const auto job = [&](int layer, int kind, int material, int lists) {
      path_job_t j{};
      j.path = ++paths_planned;
      j.batch = batch;
      j.index = int(jobs.size());
      j.layer = layer;
      j.map_id = map_id;
      j.material = std::int8_t(material);
      j.kind = std::int8_t(kind);
      j.valve = std::int8_t(kind == 3 ? 0 : material + 1);
      j.lists = lists;
      j.pulses = 10 * lists;
      j.duration_s = 1.6 * std::max(1, lists);
      j.z_mm = 0.24 * layer + 3.0;
      j.x_max_mm = j.y_max_mm = 10.0;
      jobs.push_back(j);
    };
    for (int layer = first; layer <= last; ++layer)
      for (int n = 0, count = 1 + int(random.below(3)); n < count; ++n)
        job(layer, n == 0 ? 0 : 1, int(random.below(2)), 1 + int(random.below(8) == 0));
    for (int n = 0; n < 2; ++n) job(last, 3, n, 0);
    if (refuse_path) jobs[0].text = "point 3 is out of reach";
    std::vector<std::pair<int, int>> order;  // index, list; -1 = the job
    for (path_job_t& j : jobs) {
      j.count = int(jobs.size());
      commanded[j.path] = j;
      for (int list = -1; list < j.lists; ++list) order.push_back({j.index, list});
    }
    for (std::size_t k = order.size(); k > 1; --k)
      std::swap(order[k - 1], order[random.below(std::uint32_t(k))]);
    for (const auto& [index, list] : order) {
      const path_job_t& j = jobs[std::size_t(index)];
      if (list < 0) {
        give(channels::kPathJob, j);
        continue;
      }
      pulse_list_t p{};
      p.path = j.path;
      p.list = list;
      p.lists = j.lists;
      p.valve = j.valve;
      p.start_s = 1.6 * list;
      p.tick_s = 0.002;
      p.pulse_s = 0.00125;
      p.n = empty_path && j.index == 1 ? 0 : 10;
      for (int k = 0; k < p.n; ++k) p.tick.push_back(40 * k);
      give(channels::kPulseList, p);
    }
  }

  // Carries out the newest command that has not been seen. @returns false when there is none, or it was cut
  // by a crash.
  bool serve(double crash_probability) {
    while (seen < sent.size()) {
      const Sent s = sent[seen++];
      if (s.channel == "RUN_END") return false;
      if (s.channel == "ROBOT_COMMAND") return robot(decode<robot_command_t>(s), crash_probability);
      if (s.channel == "VALVE_A_COMMAND")
        return valve(NodeId::kValveA, decode<valve_command_t>(s), crash_probability);
      if (s.channel == "VALVE_B_COMMAND")
        return valve(NodeId::kValveB, decode<valve_command_t>(s), crash_probability);
      if (s.channel == "HEATER_COMMAND") {
        const bool alive =
            answer(NodeId::kHeater, decode<heater_command_t>(s).command_id, crash_probability, 0);
        if (alive) warm(20.0);
        return alive;
      }
      if (s.channel == "LASER_COMMAND") {
        const auto c = decode<laser_command_t>(s);
        const bool alive = answer(NodeId::kLaserPoint, c.command_id, crash_probability, c.samples);
        if (alive && LaserVerb(c.verb) == LaserVerb::kCollect && c.index + 1 == c.count) send_map(c);
        return alive;
      }
      if (s.channel == "LAYER_METRICS") send_surface(decode<layer_metrics_t>(s));
    }
    return false;
  }

  bool answer(NodeId driver, std::int64_t command, double crash_probability, std::int64_t counted,
              Outcome outcome = Outcome::kDone) {
    answer_t a{};
    a.node = info(driver).name;
    a.command_id = command;
    a.outcome = std::int8_t(outcome);
    a.counted = a.expected = counted;
    if (refusals > 0 && random.below(2)) {
      --refusals;
      a.outcome = std::int8_t(Outcome::kRefused);
      give(channels::answer(driver), a);
      return true;
    }
    if (random.uniform() < crash_probability) {
      if (outcome == Outcome::kDone && driver != NodeId::kValveA && driver != NodeId::kValveB &&
          random.below(2))
        a.outcome = std::int8_t(Outcome::kNone);
      if (random.below(2)) keep(driver, a);
      crash();
      return false;
    }
    give(channels::answer(driver), a);
    return true;
  }

  void keep(NodeId driver, const answer_t& a) {
    late_driver = driver;
    unanswered = a;
  }

  bool valve(NodeId id, const valve_command_t& c, double crash_probability) {
    const bool a = id == NodeId::kValveA;
    wrong_valve = wrong_valve || commanded[c.path].valve != (a ? 1 : 2);
    if (ValveVerb(c.verb) == ValveVerb::kLoad) {
      loaded_list = {c.path, c.list};
      loaded_again = loaded_again || lost_lists.contains(loaded_list);
    }
    if (ValveVerb(c.verb) == ValveVerb::kArm && reset_while_armed > 0.0 &&
        random.uniform() < reset_while_armed) {
      lost_lists.insert({c.path, c.list});
      known_count = false;
      crash();
      return false;
    }
    if (ValveVerb(c.verb) == ValveVerb::kArm) {
      both_armed = both_armed || (armed && *armed != id);
      armed = id;
      fired = 0;
    }
    if (ValveVerb(c.verb) != ValveVerb::kDisarm) return answer(id, c.command_id, crash_probability, -1);
    armed.reset();
    // As the driver reports it: all, some, no pulse, or that its controller came back without its memory.
    const Outcome outcome = !known_count          ? Outcome::kUnknown
                            : fired == c.expected ? Outcome::kDone
                            : fired > 0           ? Outcome::kFailed
                                                  : Outcome::kNone;
    return answer(id, c.command_id, crash_probability, known_count ? fired : 0, outcome);
  }

  bool robot(const robot_command_t& c, double crash_probability) {
    if (RobotVerb(c.verb) == RobotVerb::kLoad) loaded_path = c.path;
    if (RobotVerb(c.verb) != RobotVerb::kRun)
      return answer(NodeId::kRobot, c.command_id, crash_probability, 0);
    if (commanded[c.path].kind == 3) {
      wrong_signal = wrong_signal || c.signals != kSignalLaser;
      return answer(NodeId::kRobot, c.command_id, crash_probability, 1'600'000);
    }
    wrong_signal =
        wrong_signal || !armed || c.signals != (*armed == NodeId::kValveB ? kSignalValveB : kSignalValveA);
    unloaded = unloaded || loaded_path != c.path || loaded_list.first != c.path;
    const int list = loaded_list.second;
    answer_t a{};
    a.node = "robot";
    a.command_id = c.command_id;
    a.expected = 1'600'000;
    a.counted = a.expected + slip_us;
    a.outcome = std::int8_t(Outcome::kDone);
    known_count = true;
    if (random.uniform() >= crash_probability) {
      ++runs[{c.path, list}];
      fired = fires;
      give(channels::answer(NodeId::kRobot), a);
      return true;
    }
    const int what = int(random.below(4));
    known_count = random.below(2) == 0;
    if (what == 0) {  // it was refused before anything moved
      a.outcome = std::int8_t(Outcome::kRefused);
      a.counted = 0;
      keep(NodeId::kRobot, a);
    } else {
      ++runs[{c.path, list}];
      fired = std::int64_t(random.below(11));
      if (what == 1) {
        fired = 10;
        keep(NodeId::kRobot, a);
      } else if (what == 2) {
        a.outcome = std::int8_t(Outcome::kUnknown);
        a.counted = 0;
        a.unknown_to = a.expected;
        keep(NodeId::kRobot, a);
      }
    }
    crash();
    if (what == 0) fired = 0;
    return false;
  }

  void crash() {
    armed.reset();
    safe_stop_t stop{};
    stop.enable_epoch = ++epoch;
    stop.cause = "test";
    give(channels::kSafeStop, stop);
  }

  void send_map(const laser_command_t& c) {
    ++maps;
    height_map_t m{};
    m.layer = c.layer;
    m.attempt = c.attempt;
    m.map_id = ++map_id;
    const bool dark = maps <= dark_maps;
    m.measured_fraction = dark ? 0.5 : 1.0;
    set_height(m, HeightMap(GridSpec{11, 11, 1.0, 1.0, 0.0, 0.0},
                            0.24 * c.layer * rise + (maps <= high_maps ? 2.9 : 0.0) + creep_mm * c.attempt));
    if (maps <= blind_maps) m.height_mm[60] = std::numeric_limits<float>::quiet_NaN();
    m.quality.assign(m.height_mm.size(), 0);
    give(channels::kHeightMap, m);
    if (m.layer > 0 || dark) return;  // the metrics of a layer report that the map was taken
    ++table_maps;
    layer_metrics_t taken{};
    taken.attempt = m.attempt;
    taken.map_id = m.map_id;
    send_surface(taken);
  }

  void send_surface(const layer_metrics_t& metrics) {
    done_layers = metrics.layer;
    control_surface_t c{};
    c.layer = metrics.layer;
    c.attempt = metrics.attempt;
    c.map_id = metrics.map_id;
    c.decision = std::int8_t(stop_controller ? 2 : metrics.layer >= layers ? 1 : 0);
    c.reason = stop_controller ? "saturated in 3 intervals" : "done";
    c.grid.nx = c.grid.ny = 1;
    c.grid.pitch_x_mm = c.grid.pitch_y_mm = 1.0;
    c.n = 1;
    c.u = {0.0f};
    c.feed_forward[0] = c.feed_forward[1] = 1.0;
    const bool first = random.below(2);  // the planner may be faster than the surface's way to the scheduler
    if (c.decision == 0 && first) plan(c.map_id);
    give(channels::kControlSurface, c);
    if (c.decision == 0 && !first) plan(c.map_id);
  }

  bool over() const {
    return !sent.empty() && sent.back().channel == "RUN_END" &&
           RunOutcome(decode<run_end_t>(sent.back()).outcome) == RunOutcome::kFinished;
  }
  bool is_stopped() const {
    const auto ends = all(channels::kRunEnd);
    return ends.size() > ends_seen && ((void)(ends_seen = ends.size()), true);
  }

  // Prints to the end, resuming after every crash. @returns the number of resumes; -1 = it stopped for good.
  int print(double crash_probability, bool resume = true) {
    int incarnation = 0;
    begin(0);
    for (int guard = 0; guard < 20000; ++guard) {
      if (over()) return incarnation;
      if (serve(crash_probability)) continue;
      if (over()) return incarnation;
      if (seen < sent.size()) continue;
      if (is_stopped()) {
        if (!resume) return -1;
        begin(++incarnation);
        if (accept_doubt) {
          operator_command_t c{};
          c.verb = std::int8_t(OperatorVerb::kAcceptDoubt);
          give(channels::kOperatorCommand, c);
        }
        if (seen == sent.size()) wake();  // without a driver's event, the scheduler waits for its deadline
      } else if (!wake()) {
        throw std::runtime_error("the scheduler waits for nothing");
      }
    }
    throw std::runtime_error("the print does not end");
  }

  RandomStream random;
  Experiment experiment;
  int layers;
  std::size_t seen = 0;
  mutable std::size_t ends_seen = 0;
  std::int64_t epoch = 0, map_id = 0, batch = 0, paths_planned = 0, fired = 0, slip_us = 0;
  int done_layers = 0, maps = 0, table_maps = 0, dark_maps = 0, high_maps = 0, blind_maps = 0, refusals = 0;
  double rise = 1.0;      ///< of the surface, over nominal
  double creep_mm = 0.0;  ///< of the surface, each time that it is measured again
  bool empty_path = false, refuse_path = false, stop_controller = false, known_count = true,
       accept_doubt = false;
  std::optional<answer_t> unanswered;
  NodeId late_driver = NodeId::kRobot;
  std::optional<NodeId> armed;
  std::int64_t loaded_path = 0;
  std::pair<std::int64_t, int> loaded_list{0, 0};
  std::map<std::int64_t, path_job_t> commanded;
  std::int64_t fires = 10;         ///< of the ten pulses of a list
  double reset_while_armed = 0.0;  ///< share of armings in which the valve's controller loses its power
  std::set<std::pair<std::int64_t, int>> lost_lists;
  bool loaded_again = false;                         ///< a list that was lost so
  std::map<std::pair<std::int64_t, int>, int> runs;  // (path, list) -> times it was run, whole or in part
  bool both_armed = false, wrong_signal = false, wrong_valve = false, unloaded = false;
};

}  // namespace firn::test
