#include "replay/path_audit.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "core/path/path.h"
#include "firn/camera_frame_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/valve_command_t.hpp"
#include "replay/audit_record.h"

namespace firn::replay {
namespace {

struct PathHistory {
  path_job_t job{};
  std::vector<path_report_t> reports;
  std::int64_t firings = 0, fired = 0;  ///< lists with a pulse; pulses
};

std::string path_name(const path_job_t& j) {
  return "path " + std::to_string(j.path) + " of layer " + std::to_string(j.layer);
}

class PathAudit {
 public:
  PathAudit(const runs::RunReader& messages, const std::vector<TrueFiring>* world,
            const AuditOptions& options)
      : messages_(messages), world_(world), options_(options) {
    v_.paths = true;
    v_.with_world = world != nullptr;
  }

  AuditVerdict go() {
    for (const auto* damage : {&options_.damage, &messages_.damage()})
      for (const std::string& d : *damage) add(ViolationKind::kDamaged, d);
    for (const std::string& f : messages_.forged()) add(ViolationKind::kForged, f);
    gather();
    if (world_) take_firings();
    for (const auto& [number, path] : paths_) check_path(path);
    check_doubts();
    check_looks();
    if (world_) {
      check_stops();
      check_leases();
    }
    return std::move(v_);
  }

 private:
  void add(ViolationKind kind, std::string what) { v_.add(kind, std::move(what)); }

  void gather() {
    v_.operator_orders = operator_orders(messages_);
    messages_.each<path_job_t>(channels::kPathJob.name, [&](const path_job_t& j) {
      if (PathKind(j.kind) != PathKind::kMeasurement && j.text.empty()) paths_[j.path].job = j;
    });
    // A lab of lines: the ways of its layers are its paths, the shutter's switches their pulses.
    messages_.each<line_plan_t>(channels::kLinePlan.name, [&](const line_plan_t& p) {
      if (p.path == 0) return;
      path_job_t& j = paths_[p.path].job;
      j.path = j.batch = p.path;
      j.layer = p.layer;
      j.lists = j.valve = 1;
      j.pulses = p.switches;
    });
    messages_.each<stage_command_t>(channels::kStageCommand.name, [&](const stage_command_t& c) {
      if (StageVerb(c.verb) == StageVerb::kTrace) armings_.push_back({c.header.utime_us, c.scan_id, 1});
    });
    messages_.each<path_report_t>(channels::kPathReport.name, [&](const path_report_t& r) {
      paths_[r.path].reports.push_back(r);
      v_.layers = std::max<std::int64_t>(v_.layers, r.layer);
      last_reported_ = std::max(last_reported_, r.path);
      ++v_.passes;
      v_.commanded += r.pulses_commanded;
    });
    messages_.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
      maps_.push_back({m.header.utime_us, m.map_id});
    });
    // Without a profiler the camera's pictures are what was measured.
    if (maps_.empty())
      messages_.each<camera_frame_t>(channels::kCameraFrame.name, [&](const camera_frame_t& m) {
        maps_.push_back({m.header.utime_us, m.sweep_id});
        looked_.insert(m.layer);
      });
    messages_.each<run_end_t>(channels::kRunEnd.name, [&](const run_end_t& e) {
      if (RunOutcome(e.outcome) == RunOutcome::kFinished ||
          RunOutcome(e.outcome) == RunOutcome::kOutOfTolerance) {
        v_.finished = true;
        end_us_ = e.header.utime_us;
      }
    });
    for (const auto& [channel, valve] :
         {std::pair{channels::kValveACommand, 1}, {channels::kValveBCommand, 2}})
      messages_.each<valve_command_t>(channel.name, [&, valve = valve](const valve_command_t& c) {
        if (ValveVerb(c.verb) == ValveVerb::kArm) armings_.push_back({c.header.utime_us, c.path, valve});
      });
    std::ranges::stable_sort(armings_, {}, &Arming::t_us);
    messages_.each<safe_stop_t>(channels::kSafeStop.name, [&](const safe_stop_t& s) { add_stop(s.header); });
    for (const NodeInfo& n : nodes())
      messages_.each<fault_t>(channels::fault(n.id).name, [&](const fault_t& f) {
        if (Severity(f.severity) == Severity::kStop) add_stop(f.header);
      });
    messages_.each<enable_t>(channels::kEnable.name, [&](const enable_t& e) {
      const Time t{e.header.utime_us};
      const std::int64_t before = leases_.empty() ? t.us : std::min(t.us, leases_.back().second);
      leases_.emplace_back(t.us, e.enabled ? t.after_s(e.lease_s).us : before);
    });
  }

  // Returns the path for which the valve was armed last before the trigger; 0: no path.
  std::int64_t path_of(const TrueFiring& f) const {
    std::int64_t path = 0;
    for (const Arming& a : armings_)
      if (a.valve == f.valve && a.t_us <= f.trigger_us) path = a.path;
    return path;
  }

  void take_firings() {
    for (const TrueFiring& f : *world_) {
      v_.triggered += f.fired;
      v_.fired += f.fired;
      const std::int64_t number = path_of(f);
      const auto path = paths_.find(number);
      if (path == paths_.end() || path->second.job.path == 0) {
        add(ViolationKind::kNotCommanded,
            "valve " + std::to_string(f.valve) + " at " + std::to_string(f.trigger_us) +
                " us: " + std::to_string(f.fired) + " pulses that no armed path tells of");
        continue;
      }
      path->second.fired += f.fired;
      path->second.firings += f.fired > 0;
      if (f.valve != path->second.job.valve)
        add(ViolationKind::kWrongInk,
            path_name(path->second.job) + ": fired by valve " + std::to_string(f.valve));
    }
  }

  void check_path(const PathHistory& p) {
    if (p.job.path == 0)
      return add(ViolationKind::kNotCommanded,
                 "path " + std::to_string(p.reports.front().path) + ": reported, never planned");
    if (p.reports.size() > 1)
      add(ViolationKind::kPathTwice,
          path_name(p.job) + ": reported " + std::to_string(p.reports.size()) + " times");
    if (p.reports.empty()) {
      // Paths run in the order of their numbers; a batch may be replaced before it is begun.
      if (p.job.path < last_reported_ && batch_begun(p.job.batch))
        add(ViolationKind::kSkippedPass, path_name(p.job) + ": left out");
      if (p.fired > 0 && v_.finished)
        add(ViolationKind::kNoReport,
            path_name(p.job) + ": " + std::to_string(p.fired) + " pulses, no report");
      return;
    }
    const path_report_t& r = p.reports.front();
    const bool done = Outcome(r.outcome) == Outcome::kDone;
    if (!done) {
      Unknown u;
      u.layer = r.layer;
      u.pass = std::int32_t(r.path);
      u.to = r.pulses_commanded;
      u.t_us = r.header.utime_us;
      v_.unknowns.push_back(u);
    }
    if (!world_) return;
    if (p.firings > p.job.lists)
      add(ViolationKind::kPathTwice, path_name(p.job) + ": " + std::to_string(p.firings) +
                                         " lists were fired of " + std::to_string(p.job.lists));
    if (p.fired > r.pulses_commanded)
      add(ViolationKind::kPathTwice, path_name(p.job) + ": " + std::to_string(p.fired) + " pulses of " +
                                         std::to_string(r.pulses_commanded));
    if (done && r.pulses_counted >= 0 && r.pulses_counted != p.fired)
      add(ViolationKind::kCellNotTriggered, path_name(p.job) + ": the valve counted " +
                                                std::to_string(r.pulses_counted) + " pulses, " +
                                                std::to_string(p.fired) + " were fired");
  }

  bool batch_begun(std::int64_t batch) const {
    return std::ranges::any_of(
        paths_, [&](const auto& p) { return p.second.job.batch == batch && !p.second.reports.empty(); });
  }

  void check_doubts() {
    for (Unknown& u : v_.unknowns)
      for (const auto& [t_us, map_id] : maps_)
        if (t_us > u.t_us && !u.resolved_by) u.resolved_by = map_id;
    for (const Unknown& u : v_.unknowns)
      if (!u.resolved_by && v_.finished)
        add(ViolationKind::kUnresolved, "path " + std::to_string(u.pass) + ": in doubt, and no map after it");
  }

  // A camera alone looks at every layer.
  void check_looks() {
    if (looked_.empty() || !v_.finished) return;
    for (const auto& [number, path] : paths_)
      if (!path.reports.empty() && !looked_.contains(path.reports.front().layer))
        add(ViolationKind::kUnresolved, path_name(path.job) + ": no picture of it");
  }

  // Several causes of one stop count once: the first stop of each incarnation.
  void add_stop(const header_t& h) {
    if (h.utime_us >= end_us_ || h.incarnation < 0) return;
    const auto [first, fresh] = stops_.try_emplace(h.incarnation, h.utime_us);
    if (!fresh) first->second = std::min(first->second, h.utime_us);
  }

  void check_stops() {
    const std::vector<std::int64_t>& starts = messages_.starts();
    for (const auto& [incarnation, stop] : stops_) {
      const std::size_t n = std::size_t(incarnation);
      const std::int64_t from = n < starts.size() ? starts[n] : 0;
      const std::int64_t until =
          n + 1 < starts.size() ? starts[n + 1] : std::numeric_limits<std::int64_t>::max();
      ++v_.stops;
      for (const TrueFiring& f : *world_) {
        if (f.last_us <= stop || f.trigger_us < from || f.trigger_us >= until) continue;
        const double late_s = wall_s(f.last_us - stop);
        v_.longest_stop_s = std::max(v_.longest_stop_s, late_s);
        if (late_s > options_.stop_limit_s)
          add(ViolationKind::kAfterStop, "path " + std::to_string(path_of(f)) + ": a pulse " +
                                             std::to_string(late_s) + " s after the stop");
      }
    }
  }

  // The last pulse of a list decides: a lease that ends meanwhile must end the list.
  void check_leases() {
    for (const TrueFiring& f : *world_) {
      if (f.fired == 0) continue;
      const auto next =
          std::ranges::upper_bound(leases_, f.last_us, {}, &std::pair<std::int64_t, std::int64_t>::first);
      const double late_s = next == leases_.begin() ? -1.0 : wall_s(f.last_us - std::prev(next)->second);
      if (next == leases_.begin())
        add(ViolationKind::kOutsideLease,
            "path " + std::to_string(path_of(f)) + ": a pulse before the first lease");
      else if (late_s > options_.lease_limit_s)
        add(ViolationKind::kOutsideLease, "path " + std::to_string(path_of(f)) + ": a pulse " +
                                              std::to_string(late_s) + " s after the end of the lease");
    }
  }

  double wall_s(std::int64_t us) const { return double(us) * 1e-6 / options_.time_scale; }

  struct Arming {
    std::int64_t t_us = 0, path = 0;
    int valve = 0;
  };

  const runs::RunReader& messages_;
  const std::vector<TrueFiring>* world_;
  const AuditOptions& options_;
  AuditVerdict v_;
  std::map<std::int64_t, PathHistory> paths_;
  std::int64_t last_reported_ = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> maps_;  // time, map_id or place of the picture
  std::set<std::int32_t> looked_;                            // layers that pictures show
  std::vector<Arming> armings_;
  std::map<std::int32_t, std::int64_t> stops_;                 // incarnation, first stop
  std::vector<std::pair<std::int64_t, std::int64_t>> leases_;  // time, end
  std::int64_t end_us_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace

AuditVerdict audit_paths(const runs::RunReader& messages, const std::vector<TrueFiring>* world,
                         const AuditOptions& options) {
  return PathAudit(messages, world, options).go();
}

}  // namespace firn::replay
