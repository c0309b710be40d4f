// FakeLab simulates a lab for the scheduler's tests, without instruments: it answers commands and can crash
// in the middle of any.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"
#include "core/grid/sub_patterns.h"
#include "firn/camera_command_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/droplet_sweep_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/jet_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/droplet_loop.h"
#include "tests/support/node_bench.h"

namespace firn::test {

inline Experiment small() {
  Experiment e;
  e.grid = {7, 5, 0.25, 0.25, 0.0, 0.0};
  e.control.max_layers = 50;
  return e;
}

// A lab that answers commands truthfully, counts every droplet it fires, and can crash in the middle of any
// command.
struct FakeLab : NodeBench {
  explicit FakeLab(std::uint64_t seed, const Experiment& e = small()) : FakeLab(seed, e, Mask(e.grid, 1)) {}
  FakeLab(std::uint64_t seed, const Experiment& e, const Mask& part)
      : NodeBench(NodeId::kScheduler, std::make_unique<DropletLoop>(e, HeightMap(e.grid, 0.05), part)),
        random(seed, Purpose::kTest),
        experiment(e) {}

  void begin(std::int32_t incarnation) {
    start(incarnation);
    ++epoch;
    if (unanswered) {
      const answer_t late = *unanswered;
      unanswered.reset();
      give(channels::answer(late_driver), late);
    }
    for (NodeId d : {NodeId::kStage, NodeId::kJet, NodeId::kLaserProfiler, NodeId::kLamp, NodeId::kJetB,
                     NodeId::kCamera}) {
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
  }

  void crash() {
    jetting = false;
    armed = Material::kNone;  // drivers make their instruments safe
    safe_stop_t stop{};
    stop.enable_epoch = ++epoch;
    stop.cause = "test";
    give(channels::kSafeStop, stop);
  }

  // Carries out the newest command that has not been seen. @returns false when there is none.
  bool serve(double crash_probability) {
    while (seen < sent.size()) {
      const Sent s = sent[seen++];
      if (s.channel == "RUN_END") return false;
      if (s.channel == "STAGE_COMMAND") return stage(decode<stage_command_t>(s), crash_probability);
      if (s.channel == "JET_COMMAND") return jet(NodeId::kJet, decode<jet_command_t>(s), crash_probability);
      if (s.channel == "JET_B_COMMAND")
        return jet(NodeId::kJetB, decode<jet_command_t>(s), crash_probability);
      if (s.channel == "LAMP_COMMAND") {
        wet.clear();
        return plain(NodeId::kLamp, decode<lamp_command_t>(s), crash_probability);
      }
      if (s.channel == "CAMERA_COMMAND") {
        const auto c = decode<camera_command_t>(s);
        const bool alive = plain(NodeId::kCamera, c, crash_probability);
        if (alive) {
          droplet_sweep_t m = seen_by_camera ? seen_by_camera(c) : droplet_sweep_t{};
          m.sweep_id = c.sweep_id;
          m.frames = c.frames;
          give(channels::kDropletSweep, m);
        }
        return alive;
      }
      if (s.channel == "PROFILER_COMMAND") {
        const auto c = decode<profiler_command_t>(s);
        if (ProfilerVerb(c.verb) == ProfilerVerb::kArm) scan = c;
        const bool alive = plain(NodeId::kLaserProfiler, c, crash_probability);
        if (alive && ProfilerVerb(c.verb) == ProfilerVerb::kEnd) send_map();
        return alive;
      }
      if (s.channel == "LAYER_METRICS") send_plan();
    }
    return false;
  }

  template <class Command>
  bool plain(NodeId driver, const Command& c, double crash_probability) {
    answer_t a{};
    a.node = info(driver).name;
    a.command_id = c.command_id;
    a.outcome = std::int8_t(c.command_id == unsure_command ? Outcome::kUnknown : Outcome::kDone);
    if (random.uniform() < crash_probability) {
      a.outcome = std::int8_t(random.below(2) ? Outcome::kNone : Outcome::kDone);
      if (random.below(2)) {
        late_driver = driver;
        unanswered = a;
      }
      crash();
      return false;
    }
    give(channels::answer(driver), a);
    return true;
  }

  // Arms or disarms; two jets at once are remembered for the test.
  bool jet(NodeId id, const jet_command_t& c, double crash_probability) {
    const Material ink = id == NodeId::kJetB ? Material::kB : Material::kA;
    jetting = JetVerb(c.verb) == JetVerb::kJet;
    const bool arms_small = JetVerb(c.verb) == JetVerb::kArmSmall;
    if (JetVerb(c.verb) == JetVerb::kArm || arms_small) {
      armed_small = arms_small;
      both_armed = both_armed || (armed != Material::kNone && armed != ink);
      armed = ink;
    } else if (armed == ink) {
      armed = Material::kNone;
    }
    return plain(id, c, crash_probability);
  }

  bool stage(const stage_command_t& c, double crash_probability) {
    moved_while_jetting = moved_while_jetting || jetting;
    if (StageVerb(c.verb) != StageVerb::kPass) return plain(NodeId::kStage, c, crash_probability);
    DropletPattern drops(experiment.grid);
    drops.cells.assign(c.fires.begin(), c.fires.end());
    const Placement placement = placement_of(c, OffsetTable(experiment.actuation));
    const auto order = firing_order(drops, 0, placement);
    const std::size_t n = order.size();
    answer_t a{};
    a.node = "stage";
    a.command_id = c.command_id;
    a.expected = std::int64_t(n);
    std::size_t fire = n;
    const bool dies = random.uniform() < crash_probability;
    bool says_nothing = false;
    if (dies) {
      fire = random.below(std::uint32_t(n + 1));
      switch (random.below(4)) {
        case 0:  // the instrument's counter tells exactly
          a.outcome = std::int8_t(fire == n ? Outcome::kDone : Outcome::kNone);
          a.counted = std::int64_t(fire);
          break;
        case 1: {  // only a range is known
          const std::size_t from = random.below(std::uint32_t(fire + 1));
          a.outcome = std::int8_t(Outcome::kUnknown);
          a.counted = std::int64_t(from);
          a.unknown_from = std::int64_t(from);
          a.unknown_to = std::int64_t(fire + random.below(std::uint32_t(n - fire + 1)));
          break;
        }
        case 2:  // it was refused before anything moved
          fire = 0;
          a.outcome = std::int8_t(Outcome::kRefused);
          a.counted = 0;
          break;
        default:  // the driver comes back and knows nothing of it
          says_nothing = true;
      }
    } else {
      a.outcome = std::int8_t(Outcome::kDone);
      a.counted = std::int64_t(n);
    }
    for (std::size_t k = 0; k < fire; ++k) {
      ++fired[{c.layer, c.pass_index}][order[k]];
      droplets[c.layer][order[k]].push_back(armed);
      const int wanted = c.layer <= layers ? places.at(c.layer).of(order[k]) : 0;
      beside_place = beside_place || placement.map.of(order[k]) != wanted;
      other_size = other_size || placement.small(order[k]) != armed_small;
      small_drops += armed_small;
      wet.push_back(order[k]);
    }
    // Between two cures all lies in one sub-pattern.
    const int n_sub = experiment.process.sub_patterns, nx = experiment.grid.nx;
    for (const std::uint32_t cell : wet)
      wet_contact = wet_contact || sub_pattern_of(int(cell) % nx, int(cell) / nx, n_sub) !=
                                       sub_pattern_of(int(wet[0]) % nx, int(wet[0]) / nx, n_sub);
    const double shift = armed == Material::kB ? experiment.jet_b.offset_x_mm : 0.0;
    wrong_place = wrong_place || c.grid.origin_x_mm != experiment.grid.origin_x_mm - shift;
    if (!dies) {
      give(channels::answer(NodeId::kStage), a);
      return true;
    }
    if (!says_nothing) {
      late_driver = NodeId::kStage;
      unanswered = a;
    }
    crash();
    return false;
  }

  void send_map() {
    height_map_t m{};
    m.layer = scan.layer;
    m.attempt = scan.attempt;
    m.map_id = ++map_id;
    m.measured_fraction = 1.0;
    set_height(m, HeightMap(experiment.grid, rise_mm * scan.layer));
    m.quality.assign(m.height_mm.size(), 0);
    if (alter_map) alter_map(m);
    give(channels::kHeightMap, m);
  }

  void send_plan() {
    const auto metrics = all(channels::kLayerMetrics).back();
    layer_plan_t p{};
    p.layer = metrics.layer + 1;
    p.attempt = metrics.attempt;
    p.map_id = metrics.map_id;
    DropletPattern drops(experiment.grid);
    if (p.layer > layers) {
      p.decision = std::int8_t(PlanDecision::kEnd);
    } else {
      for (std::size_t c = 0; c < drops.size(); ++c) drops.cells[c] = std::uint8_t(random.below(3));
      planned[p.layer] = drops;
    }
    set_drops(p, drops);
    const auto table_size = std::uint32_t(OffsetTable(experiment.actuation).size());
    OffsetMap& map = places[p.layer] = table_size > 1 ? OffsetMap(experiment.grid) : OffsetMap();
    for (std::size_t c = 0; c < map.size(); ++c)
      map.cells[c] = std::uint8_t(
          random_below({7, Purpose::kTest, std::uint32_t(p.layer), 0, std::uint32_t(c)}, table_size));
    set_offsets(p, map);
    MaterialMap materials(experiment.grid);
    for (std::size_t c = 0; c < drops.size(); ++c)
      materials.set(c, random.below(2) ? Material::kA : Material::kB);
    const bool two = has_two_jets(experiment);
    if (two) set_materials(p, materials);
    if (two && drops.passes()) inks[p.layer] = materials;
    give(channels::kLayerPlan, p);
  }

  // Prints to the end, resuming after every crash. @returns the number of crashes.
  int print(double crash_probability) {
    int incarnation = 0;
    begin(0);
    for (int guard = 0; guard < 20000; ++guard) {
      if (host.finished() == 0 || (!all(channels::kRunEnd).empty() &&
                                   RunOutcome(last(channels::kRunEnd).outcome) == RunOutcome::kFinished))
        return incarnation;
      if (serve(crash_probability)) continue;
      if (!all(channels::kRunEnd).empty() &&
          RunOutcome(last(channels::kRunEnd).outcome) == RunOutcome::kFinished)
        return incarnation;
      if (seen < sent.size()) continue;
      if (is_stopped()) {
        begin(++incarnation);
        // Without a driver's event, the scheduler waits for its deadline.
        if (seen == sent.size()) wake();
      } else if (!wake()) {
        throw std::runtime_error("the scheduler waits for nothing");
      }
    }
    throw std::runtime_error("the print does not end");
    return -1;
  }
  bool is_stopped() const {
    const auto ends = all(channels::kRunEnd);
    return ends.size() > ends_seen && ((void)(ends_seen = ends.size()), true);
  }

  RandomStream random;
  Experiment experiment;
  int layers = 4;
  double rise_mm = 0.0076;  ///< of each layer; its droplets' own
  std::function<droplet_sweep_t(const camera_command_t&)> seen_by_camera;
  std::function<void(height_map_t&)> alter_map;
  std::int64_t unsure_command = -1;  ///< answered with kUnknown
  std::size_t seen = 0;
  mutable std::size_t ends_seen = 0;
  std::int64_t epoch = 0, map_id = 0;
  profiler_command_t scan{};
  std::optional<answer_t> unanswered;
  NodeId late_driver = NodeId::kStage;
  std::map<int, DropletPattern> planned;
  std::map<int, MaterialMap> inks;
  std::map<int, OffsetMap> places;  ///< of the plans; without cells: all in the centres
  std::map<int, std::map<std::uint32_t, std::vector<Material>>>
      droplets;                    // layer -> cell -> jets that fired on it
  std::vector<std::uint32_t> wet;  // cells fired since the last cure
  Material armed = Material::kNone;
  bool jetting = false, moved_while_jetting = false;
  bool both_armed = false, wet_contact = false, wrong_place = false, beside_place = false;
  bool armed_small = false, other_size = false;  ///< a droplet of another size than planned
  int small_drops = 0;
  std::map<std::pair<int, int>, std::map<std::uint32_t, int>> fired;  // (layer, pass) -> cell -> triggers
};

}  // namespace firn::test
