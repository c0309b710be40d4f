// Violations planted into clean runs, each by rewriting the records of all nodes and of the world alike: the
// audit names every one by its kind.
#include <catch2/catch.hpp>

#include <algorithm>
#include <set>

#include "core/grid/random.h"
#include "firn/deposition_report_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/valve_command_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "runs/read/run_reader.h"
#include "tests/cli/run_firn.h"
#include "tests/replay/damage.h"
#include "tests/replay/forge.h"
#include "tests/support/tiny_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using plant::WorldHistory;
using replay::ViolationKind;

template <class Message>
std::vector<Message> messages(const fs::path& run, std::string_view channel) {
  std::vector<Message> all;
  runs::RunReader(run).each<Message>(channel, [&](const Message& m) { all.push_back(m); });
  return all;
}

/// A run folder with what the planted violations choose from.
struct Victim {
  fs::path run;
  RandomStream random;
  std::vector<stage_command_t> passes;
  std::vector<path_report_t> paths;
  WorldHistory world;

  Victim(const fs::path& folder, std::uint64_t seed) : run(folder), random(seed, Purpose::kTest) {
    for (stage_command_t& c : messages<stage_command_t>(run, channels::kStageCommand.name))
      if (StageVerb(c.verb) == StageVerb::kPass) passes.push_back(std::move(c));
    paths = messages<path_report_t>(run, channels::kPathReport.name);
    world = plant::read_history(run / "world.rec");
  }
  std::size_t any(std::size_t n) { return random.below(std::uint32_t(n)); }
  const stage_command_t& pass() { return passes[any(passes.size())]; }
  const stage_command_t& earlier_pass() { return passes[any(passes.size() - 1)]; }
  /// Also for a path of the ice printer: node time of what was commanded.
  std::int64_t end_of(const stage_command_t& c) const {
    for (const stage_command_t& next : passes)
      if (next.header.utime_us > c.header.utime_us) return next.header.utime_us;
    return INT64_MAX;
  }
  void drop_shots(std::int64_t from, std::int64_t to) const {
    edit_world(run, [&](WorldHistory& h) {
      std::erase_if(h.shots, [&](const auto& s) { return s.t_us >= from && s.t_us < to; });
    });
  }
  template <class Message>
  void edit(std::string_view channel, const std::function<bool(Message&)>& change) const {
    edit_messages<Message>(run, channel, change);
  }
  void edit_report(const stage_command_t& c, const std::function<bool(deposition_report_t&)>& change) const {
    edit<deposition_report_t>(channels::kDepositionReport.name, [&](deposition_report_t& r) {
      return r.layer != c.layer || r.pass_index != c.pass_index || change(r);
    });
  }
  void add_stop(std::int64_t t_us) const {
    const std::string node = fs::exists(run / "nodes" / "jet.wal") ? "jet" : "robot";
    Outbox out(find_node(node)->id, 1);
    out.begin(Time{t_us}, 0);
    fault_t fault{};
    fault.severity = std::int8_t(Severity::kStop);
    fault.node = node;
    fault.text = "planted";
    out.send(channels::fault(find_node(node)->id), fault);
    add_messages(run, node, out);
  }
  void no_lease(std::int64_t from, std::int64_t to) const {
    edit<enable_t>(channels::kEnable.name, [&](enable_t& e) {
      if (e.header.utime_us >= from && e.header.utime_us < to) e.enabled = 0;
      return true;
    });
  }
  std::int64_t last_fired_us() const {
    std::int64_t last = 0;
    for (const auto& s : world.shots) last = std::max(last, s.t_us);
    for (const auto& f : world.firings) last = std::max(last, f.last_us);
    return last;
  }
};

void flip_in(const fs::path& file, RandomStream& random) {
  auto bytes = read_bytes(file);
  flip(bytes, bytes.size() / 4 + random.below(std::uint32_t(bytes.size() / 2)) / 8 * 8 + 3);
  write_bytes(file, bytes);
}

std::size_t device(const WorldHistory& h, plant::DeviceEvent event, std::size_t n) {
  for (std::size_t k = 0; k < h.devices.size(); ++k)
    if (h.devices[k].event == event && n-- == 0) return k;
  FAIL("no such device record");
  return 0;
}

using Plant = void (*)(Victim&);
struct Planted {
  const char* name;
  ViolationKind kind;
  Plant plant;
};

constexpr Planted kAnywhere[] = {
    {"a byte of a node's file", ViolationKind::kDamaged,
     [](Victim& v) { flip_in(v.run / "nodes" / "scheduler.wal", v.random); }},
    {"a byte of the world's record", ViolationKind::kDamaged,
     [](Victim& v) { flip_in(v.run / "world.rec", v.random); }},
    {"a missing node's file", ViolationKind::kDamaged,
     [](Victim& v) { fs::remove(v.run / "nodes" / (v.any(2) ? "safety.wal" : "controller.wal")); }},
    {"a stop before the last droplets", ViolationKind::kAfterStop,
     [](Victim& v) { v.add_stop(v.last_fired_us() - 1'500'000 - std::int64_t(v.any(1'000'000))); }},
    {"a lease that had run out", ViolationKind::kOutsideLease,
     [](Victim& v) { v.no_lease(v.last_fired_us() - 2'000'000, INT64_MAX); }},
    {"leases of a millisecond", ViolationKind::kOutsideLease,
     [](Victim& v) {
       v.edit<enable_t>(channels::kEnable.name, [&](enable_t& e) {
         e.lease_s = 0.001;
         e.enabled = e.header.utime_us < v.last_fired_us() - 3'000'000;
         return true;
       });
     }},
};

constexpr Planted kDroplets[] = {
    {"a layer skipped", ViolationKind::kSkippedLayer,
     [](Victim& v) {
       const int layer = 1 + int(v.any(std::size_t(v.passes.back().layer - 1)));
       for (const auto& c : v.passes)
         if (c.layer == layer) v.drop_shots(c.header.utime_us, v.end_of(c));
       v.edit<stage_command_t>(channels::kStageCommand.name, [&](auto& c) {
         return c.layer != layer || StageVerb(c.verb) != StageVerb::kPass;
       });
       v.edit<deposition_report_t>(channels::kDepositionReport.name,
                                   [&](auto& r) { return r.layer != layer; });
     }},
    {"the last pass on the first layer again", ViolationKind::kLayerTwice,
     [](Victim& v) {
       v.edit<stage_command_t>(channels::kStageCommand.name, [&](auto& c) {
         if (c.command_id == v.passes.back().command_id) c.layer = 1;
         return true;
       });
     }},
    {"a pass that ended early", ViolationKind::kSkippedPass,
     [](Victim& v) {
       const auto& c = v.earlier_pass();
       v.edit_report(c, [](deposition_report_t& r) {
         r.unknown_from = r.unknown_to = r.commanded - 1;
         return true;
       });
       std::int64_t last = 0;
       for (const auto& s : v.world.shots)
         if (s.t_us >= c.header.utime_us && s.t_us < v.end_of(c)) last = s.t_us;
       v.drop_shots(last, last + 1);
     }},
    {"another cell than planned", ViolationKind::kOtherCells,
     [](Victim& v) {
       const auto chosen = v.pass();
       v.edit<stage_command_t>(channels::kStageCommand.name, [&](auto& c) {
         if (c.command_id != chosen.command_id) return true;
         const auto fired = std::ranges::find(c.fires, 1), free = std::ranges::find(c.fires, 0);
         if (fired != c.fires.end() && free != c.fires.end()) std::swap(*fired, *free);
         return true;
       });
     }},
    {"a decision altered", ViolationKind::kOtherCells,
     [](Victim& v) {
       const int layer = v.pass().layer;
       v.edit<layer_plan_t>(channels::kLayerPlan.name, [&](auto& p) {
         if (p.layer == layer) {
           const auto fired = std::ranges::find(p.drops, 1), free = std::ranges::find(p.drops, 0);
           if (fired == p.drops.end()) return true;
           *fired = 0;
           if (free != p.drops.end()) *free = 1;
         }
         return true;
       });
     }},
    {"a decision gone", ViolationKind::kOtherCells,
     [](Victim& v) {
       const int layer = v.pass().layer;
       v.edit<layer_plan_t>(channels::kLayerPlan.name, [&](auto& p) { return p.layer != layer; });
     }},
    {"a report gone", ViolationKind::kNoReport,
     [](Victim& v) { v.edit_report(v.pass(), [](auto&) { return false; }); }},
    {"droplets in doubt, and the map is older", ViolationKind::kUnresolved,
     [](Victim& v) {
       const stage_command_t* last = &v.passes.front();  // of its layer, and a layer follows
       for (const auto& c : v.passes)
         if (c.layer < v.passes.back().layer) last = &c;
       std::int64_t at = 0;
       v.edit_report(*last, [&](deposition_report_t& r) {
         r.unknown_from = std::int64_t(v.any(std::size_t(r.commanded)));
         r.unknown_to = r.commanded;
         at = r.header.utime_us;
         return true;
       });
       v.edit<height_map_t>(channels::kHeightMap.name, [&](auto& m) {
         if (m.layer == last->layer) m.sample_utime_us = at - 1;
         return true;
       });
     }},
    {"a second droplet on a cell", ViolationKind::kCellTwice,
     [](Victim& v) {
       const std::size_t n = v.any(v.world.shots.size());
       edit_world(v.run,
                  [&](WorldHistory& h) { h.shots.insert(h.shots.begin() + std::ptrdiff_t(n), h.shots[n]); });
     }},
    {"a droplet beside the pass", ViolationKind::kCellNotCommanded,
     [](Victim& v) {
       const std::size_t n = v.any(v.world.shots.size());
       edit_world(v.run, [&](WorldHistory& h) {
         h.shots[n].i = h.shots[n].j = -1;
         h.shots[n].x_mm = h.shots[n].y_mm = -10.0;
       });
     }},
    {"a droplet that did not come", ViolationKind::kCellNotTriggered,
     [](Victim& v) {
       const std::int64_t at = v.world.shots[v.any(v.world.shots.size())].t_us;
       v.drop_shots(at, at + 1);
     }},
    {"a trigger that the jet ignored", ViolationKind::kCellNotTriggered,
     [](Victim& v) {
       const std::size_t n = v.any(v.world.shots.size());
       edit_world(v.run, [&](WorldHistory& h) { h.shots[n].outcome = plant::ShotOutcome::kGatedSource; });
     }},
    {"a droplet that no report counts", ViolationKind::kCellNotReported,
     [](Victim& v) {
       v.edit_report(v.pass(), [](deposition_report_t& r) {
         r.unknown_from = r.unknown_to = r.commanded - 1;
         return true;
       });
     }},
    {"a droplet before any command", ViolationKind::kNotCommanded,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         h.shots.insert(h.shots.begin(), h.shots[v.any(h.shots.size())]);
         h.shots.front().t_us = 1 + std::int64_t(v.any(1000));
       });
     }},
    {"a jet that was not armed", ViolationKind::kDisarmed,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         h.devices.erase(h.devices.begin() + std::ptrdiff_t(device(h, plant::DeviceEvent::kJetArmed,
                                                                   v.any(v.passes.size() / 2))));
       });
     }},
    {"a layer that was not cured", ViolationKind::kNotCured,
     [](Victim& v) {
       const int last = v.passes.back().layer;
       std::int64_t from = 0;
       for (const auto& c : v.passes)
         if (c.layer == last && from == 0) from = c.header.utime_us;
       edit_world(v.run, [&](WorldHistory& h) {
         for (auto& s : h.shots)
           if (s.t_us >= from) s.exposures = 0;
       });
     }},
};

constexpr Planted kTwoInks[] = {
    {"a pass skipped", ViolationKind::kSkippedPass,
     [](Victim& v) {
       const auto c = v.earlier_pass();
       v.drop_shots(c.header.utime_us, v.end_of(c));
       v.edit<stage_command_t>(channels::kStageCommand.name,
                               [&](auto& x) { return x.command_id != c.command_id; });
       v.edit_report(c, [](auto&) { return false; });
     }},
    {"the other ink", ViolationKind::kWrongInk,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         std::size_t n = v.any(h.shots.size());
         while (h.shots[n].nozzle != 1) n = (n + 1) % h.shots.size();
         h.shots[n].nozzle = 0;
       });
     }},
    {"a wet neighbour", ViolationKind::kWetNeighbour,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         for (auto& s : h.shots) s.exposures -= s.exposures % 2;
       });
     }},
    {"both jets armed", ViolationKind::kBothArmed,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         std::erase_if(h.devices, [&](const auto& d) {
           return d.event == plant::DeviceEvent::kJetDisarmed && d.port == plant::Port::kJet;
         });
       });
     }},
};

constexpr Planted kIce[] = {
    {"a list fired twice", ViolationKind::kPathTwice,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         std::size_t n = v.any(h.firings.size());
         while (h.firings[n].fired == 0) n = (n + 1) % h.firings.size();
         h.firings.insert(h.firings.begin() + std::ptrdiff_t(n), h.firings[n]);
       });
     }},
    {"a path reported twice", ViolationKind::kPathTwice,
     [](Victim& v) {
       const std::int64_t path = v.paths[1 + v.any(v.paths.size() - 1)].path;
       v.edit<path_report_t>(channels::kPathReport.name, [&](auto& r) {
         if (r.path == path) --r.path;
         return true;
       });
     }},
    {"a path left out", ViolationKind::kSkippedPass,
     [](Victim& v) {
       const std::int64_t path = v.paths[v.any(v.paths.size() - 1)].path;
       v.edit<path_report_t>(channels::kPathReport.name, [&](auto& r) { return r.path != path; });
     }},
    {"pulses without a report", ViolationKind::kNoReport,
     [](Victim& v) {
       const std::int64_t path = v.paths[v.any(v.paths.size())].path;
       v.edit<path_report_t>(channels::kPathReport.name, [&](auto& r) { return r.path != path; });
     }},
    {"pulses before any path", ViolationKind::kNotCommanded,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         std::size_t n = v.any(h.firings.size());
         while (h.firings[n].fired == 0) n = (n + 1) % h.firings.size();
         h.firings[n].trigger_us = 1;
       });
     }},
    {"a plan gone", ViolationKind::kNotCommanded,
     [](Victim& v) {
       const std::int64_t path = v.paths[v.any(v.paths.size())].path;
       v.edit<path_job_t>(channels::kPathJob.name, [&](auto& j) { return j.path != path; });
     }},
    {"the other valve", ViolationKind::kWrongInk,
     [](Victim& v) {
       std::int64_t other = 0;
       for (const auto& j : messages<path_job_t>(v.run, channels::kPathJob.name))
         if (ValveId(j.valve) == ValveId::kB) other = j.path;
       std::size_t n = 0;
       const std::size_t chosen = v.any(4);
       std::set<std::int64_t> mine;
       v.edit<valve_command_t>(channels::kValveACommand.name, [&](auto& c) {
         if (ValveVerb(c.verb) != ValveVerb::kArm) return true;
         if (mine.empty() && n++ == chosen) mine.insert(c.path);
         if (mine.contains(c.path)) c.path = other;
         return true;
       });
     }},
    {"a path in doubt, and no map", ViolationKind::kUnresolved,
     [](Victim& v) {
       const path_report_t chosen = v.paths[v.any(v.paths.size())];
       v.edit<path_report_t>(channels::kPathReport.name, [&](auto& r) {
         if (r.path == chosen.path) r.outcome = std::int8_t(Outcome::kUnknown);
         return true;
       });
       v.edit<height_map_t>(channels::kHeightMap.name,
                            [&](auto& m) { return m.header.utime_us <= chosen.header.utime_us; });
     }},
    {"a count that is not the truth", ViolationKind::kCellNotTriggered,
     [](Victim& v) {
       const std::int64_t path = v.paths[v.any(v.paths.size())].path;
       v.edit<path_report_t>(channels::kPathReport.name, [&](auto& r) {
         if (r.path == path) r.pulses_counted += 1;
         return true;
       });
     }},
    {"a pulse that the valve left out", ViolationKind::kCellNotTriggered,
     [](Victim& v) {
       edit_world(v.run, [&](WorldHistory& h) {
         std::size_t n = v.any(h.firings.size());
         while (h.firings[n].fired == 0) n = (n + 1) % h.firings.size();
         --h.firings[n].fired;
       });
     }},
};

class Ground {
 public:
  explicit Ground(const fs::path& clean) : clean_(clean) {
    const replay::AuditVerdict v = replay::audit_run(clean);
    INFO(clean << ": " << to_text(v));
    REQUIRE(v.clean());
  }
  int named(std::span<const Planted> all, std::uint64_t seeds) const {
    int n = 0;
    for (const Planted& p : all)
      for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        const fs::path run = fresh_folder("planted") / "run";
        fs::copy(clean_, run, fs::copy_options::recursive);
        Victim victim(run, seed);
        p.plant(victim);
        const replay::AuditVerdict v = replay::audit_run(run);
        CAPTURE(p.name, seed, clean_, to_text(v));
        const bool found = std::ranges::any_of(
            v.violations, [&](const replay::Violation& x) { return x.kind == p.kind && x.what.size() > 10; });
        CHECK(found);
        n += found;
      }
    return n;
  }

 private:
  fs::path clean_;
};

TEST_CASE("the audit names every violation that is planted into a clean run") {
  const Experiment e = tiny_print("planted");
  const runs::RunFolder printed = runs::RunFolder::create(fresh_folder("planted-ground"), e,
                                                          make_inputs(full_product(), e, ""), {"test"});
  REQUIRE(run_in_lab(full_product(), printed, {}).result.status == 0);
  int named = 0;
  for (const fs::path& clean : {printed.path(), golden("v5-two-inks")}) {
    const Ground ground(clean);
    named += ground.named(kAnywhere, 1);
    named += ground.named(kDroplets, 2);
  }
  named += Ground(golden("v5-two-inks")).named(kTwoInks, 2);
  const Ground ice(golden("v5-ice"));
  named += ice.named(kAnywhere, 1);
  named += ice.named(kIce, 2);
  CHECK(named >= 50);
}

}  // namespace
}  // namespace firn::test
