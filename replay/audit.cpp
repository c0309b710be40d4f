#include "replay/audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/grid/firing_order.h"
#include "core/grid/sub_patterns.h"
#include "replay/audit_index.h"

namespace firn::replay {
namespace {

std::string pass_name(const PassOrder& o) {
  return "layer " + std::to_string(o.layer) + ", pass " + std::to_string(o.pass + 1) +
         (o.attempt ? ", attempt " + std::to_string(o.attempt) : "");
}

std::string at(std::int64_t t_us) { return " at " + std::to_string(t_us) + " us"; }

constexpr int kReach = 4;  // cells along x in which the droplet of a shot is looked for: its lead is less

std::string cell(const GridSpec& g, std::uint32_t c) {
  return "cell (" + std::to_string(int(c) % g.nx) + ", " + std::to_string(int(c) / g.nx) + ")";
}

class Audit {
 public:
  Audit(const AuditRecord& record, const WorldTruth* world, const AuditOptions& options)
      : record_(record), world_(world), options_(options), index_(record), shots_(record.orders.size()) {}

  AuditVerdict go() {
    v_.finished = record_.finished;
    v_.operator_orders = record_.operator_orders;
    v_.with_world = world_ != nullptr;
    for (const auto* damage : {&options_.damage, &record_.damage})
      for (const std::string& d : *damage) add(ViolationKind::kDamaged, d);
    for (const std::string& f : record_.forged) add(ViolationKind::kForged, f);
    check_layers();
    for (std::size_t n = 0; n < record_.orders.size(); ++n) check_order(n);
    check_unknowns();
    if (world_) check_world();
    count_commanded();
    v_.compared += index_.compared();
    return std::move(v_);
  }

 private:
  void add(ViolationKind kind, std::string what) { v_.add(kind, std::move(what)); }

  // The stage refused the command, as before its lease, and received it again: the report is that of the
  // later command.
  bool given_again(std::size_t n) const {
    if (n + 1 >= record_.orders.size()) return false;
    const PassOrder &o = record_.orders[n], &next = record_.orders[n + 1];
    if (next.layer != o.layer || next.attempt != o.attempt || next.pass != o.pass) return false;
    const PassReport* r = index_.report_of(o);
    return !r || r->t_us >= next.t_us;
  }

  // Returns the cells that a first attempt at a pass must fire.
  std::vector<std::uint32_t> cells_of(const PlannedLayer& plan, const PassOrder& o) const {
    const PassPart* part = index_.part_of(o);
    Placement placement = o.placement;
    placement.map = plan.offsets;
    DropletPattern drops = plan.drops;
    for (std::uint32_t c = 0; part && c < drops.size(); ++c) {
      const int i = int(c) % drops.spec.nx, j = int(c) / drops.spec.nx;
      const Material ink = plan.materials.cells.empty() ? Material::kA : plan.materials.of(c);
      if (sub_pattern_of(i, j, part->sub_patterns) != part->sub_pattern || ink != part->material ||
          placement.small(c) != small_of(o))
        drops.cells[c] = 0;
    }
    return firing_order(drops, part ? part->round : o.pass, placement);
  }

  // Returns true if the droplets of a pass are aimed where the plan wants them in their cells.
  static bool at_places_of(const PlannedLayer& plan, const PassOrder& o) {
    return std::ranges::all_of(o.cells,
                               [&](std::uint32_t c) { return o.placement.map.of(c) == plan.offsets.of(c); });
  }

  // The size of a pass's droplets is that of the first one; the others must have it too.
  static bool small_of(const PassOrder& o) { return !o.cells.empty() && o.placement.small(o.cells.front()); }

  // Each pass has droplets of the size for which the jet was last armed.
  void check_size(const PassOrder& o) {
    if (record_.arms.empty()) return;
    const bool small = small_of(o);
    const auto next = std::ranges::upper_bound(record_.arms, o.t_us, {}, &ArmOrder::t_us);
    const bool armed_small = next != record_.arms.begin() && std::prev(next)->small;
    if (armed_small != small ||
        std::ranges::any_of(o.cells, [&](std::uint32_t c) { return o.placement.small(c) != small; }))
      add(ViolationKind::kOtherSize, pass_name(o) +
                                         ": its droplets are not of the size for which the jet "
                                         "was armed");
  }

  // For a pass that was cut off before its report, no record holds its part of the layer.
  bool cut_off(const PassOrder& o) const { return is_last(o) && !record_.finished && !index_.report_of(o); }

  bool is_last(const PassOrder& o) const { return &o == &record_.orders.back(); }

  void check_layers() {
    std::int32_t last = 0;
    std::set<std::int32_t> begun;
    for (const PassOrder& o : record_.orders) {
      if (o.layer == last) continue;
      if (begun.contains(o.layer))
        add(ViolationKind::kLayerTwice, "layer " + std::to_string(o.layer) +
                                            " was deposited again after layer " + std::to_string(last) +
                                            at(o.t_us));
      else
        for (std::int32_t skipped = last + 1; skipped < o.layer; ++skipped)
          add(ViolationKind::kSkippedLayer, "layer " + std::to_string(skipped) + " was skipped: layer " +
                                                std::to_string(o.layer) + " follows layer " +
                                                std::to_string(last));
      begun.insert(o.layer);
      last = o.layer;
    }
    v_.layers = std::int64_t(begun.size());
    for (std::int32_t layer : begun) check_passes(layer);
  }

  void check_passes(std::int32_t layer) {
    std::set<std::int32_t> passes;
    std::set<std::int64_t> map_ids;
    bool in_doubt = false;
    const PassOrder* last = nullptr;
    for (const std::size_t n : index_.orders_of(layer)) {
      const PassOrder& o = record_.orders[n];
      ++v_.compared;
      passes.insert(o.pass);
      last = &o;
      if (const PassReport* r = index_.report_of(o)) {
        map_ids.insert(r->map_id);
        in_doubt |= r->unknown_to > r->unknown_from;
      }
    }
    v_.passes += std::int64_t(passes.size());
    if (map_ids.size() > 1)
      add(ViolationKind::kLayerTwice,
          "layer " + std::to_string(layer) + " was deposited by plans of two maps, " +
              std::to_string(*map_ids.begin()) + " and " + std::to_string(*map_ids.rbegin()));
    const PlannedLayer* plan = index_.plan_of(*last);
    const bool cut_short = is_last(*last) && !record_.finished;
    if (!plan || in_doubt || cut_short) return;  // check_order reports a missing plan
    const std::int32_t wanted = index_.passes_of(*plan);
    for (std::int32_t pass = 0; pass < wanted; ++pass)
      if (!passes.contains(pass))
        add(ViolationKind::kSkippedPass, "layer " + std::to_string(layer) + ": pass " +
                                             std::to_string(pass + 1) + " of " + std::to_string(wanted) +
                                             " was skipped");
    std::int64_t commanded = 0;
    for (const std::size_t n : index_.orders_of(layer))
      if (record_.orders[n].attempt == 0)
        commanded += std::int64_t(record_.orders[n].cells.size()) * !given_again(n);
    if (commanded != plan->drops.total())
      add(ViolationKind::kSkippedPass, "layer " + std::to_string(layer) + ": its passes fire " +
                                           std::to_string(commanded) + " droplets, the plan has " +
                                           std::to_string(plan->drops.total()));
  }

  void check_order(std::size_t n) {
    const PassOrder& o = record_.orders[n];
    const PlannedLayer* plan = index_.plan_of(o);
    if (!plan)
      add(ViolationKind::kOtherCells, pass_name(o) + ": no plan asked for it");
    else if (!at_places_of(*plan, o))
      add(ViolationKind::kOtherCells,
          pass_name(o) + ": the stage was sent to other places in the cells than the plan of map " +
              std::to_string(plan->map_id) + " names");
    else if (o.attempt == 0 && cells_of(*plan, o) != o.cells && !(cut_off(o) && within(*plan, o)))
      add(ViolationKind::kOtherCells, pass_name(o) +
                                          ": the stage was sent to other cells than the plan of map " +
                                          std::to_string(plan->map_id) + " names");
    check_size(o);
    if (given_again(n)) return;
    const PassReport* r = index_.report_of(o);
    if (!r) {
      if (!is_last(o) || record_.finished)
        add(ViolationKind::kNoReport, pass_name(o) + ": no report, and the print went on");
      return;
    }
    const std::int64_t cells = std::int64_t(o.cells.size());
    if (r->unknown_to > r->unknown_from)
      v_.unknowns.push_back({o.layer, o.attempt, o.pass, r->unknown_from, r->unknown_to, r->t_us, {}});
    else if (r->unknown_from < cells && !is_last(o) &&
             (record_.orders[n + 1].layer != o.layer || record_.orders[n + 1].pass != o.pass))
      add(ViolationKind::kSkippedPass,
          pass_name(o) + ": " + std::to_string(cells - r->unknown_from) + " droplets were left out");
  }

  static bool within(const PlannedLayer& plan, const PassOrder& o) {
    return std::ranges::all_of(
        o.cells, [&](std::uint32_t c) { return c < plan.drops.size() && plan.drops.cells[c] > 0; });
  }

  // Droplets in doubt must be seen by a scan before the next ones are planned.
  void check_unknowns() {
    for (Unknown& u : v_.unknowns) {
      if (const MeasuredMap* m = index_.map_after(u.t_us)) u.resolved_by = m->map_id;
      const std::string what = "layer " + std::to_string(u.layer) + ", pass " + std::to_string(u.pass + 1) +
                               ", droplets " + std::to_string(u.from) + " to " + std::to_string(u.to) +
                               " in doubt: ";
      const std::size_t next = index_.order_after(u.t_us);
      if (next == record_.orders.size()) {
        if (record_.finished && !u.resolved_by)
          add(ViolationKind::kUnresolved, what + "the print ended without a scan");
        continue;
      }
      const PlannedLayer* plan = index_.plan_of(record_.orders[next]);
      if (!plan || !index_.measured_after(plan->map_id, u.t_us)) {
        u.resolved_by.reset();
        add(ViolationKind::kUnresolved,
            what + pass_name(record_.orders[next]) + " was planned without a scan after it");
      }
    }
  }

  void check_world() {
    if (world_->damaged)
      add(ViolationKind::kDamaged,
          "the world's own record is damaged in " + std::to_string(world_->damaged) + " places");
    assign_shots();
    struct Fired {
      std::size_t orders = 0;   // still to come
      std::vector<bool> cells;  // that got a droplet
    };
    std::map<std::pair<std::int32_t, std::int32_t>, Fired> fired;  // by layer, pass
    const auto key = [](const PassOrder& o) { return std::pair(o.layer, o.pass); };
    for (const PassOrder& o : record_.orders) ++fired[key(o)].orders;
    for (std::size_t n = 0; n < record_.orders.size(); ++n) {
      const auto of_pass = fired.find(key(record_.orders[n]));
      check_shots(n, of_pass->second.cells);
      if (--of_pass->second.orders == 0) fired.erase(of_pass);
    }
    check_stops();
    check_leases();
    check_disarmed();
  }

  // A shot belongs to the last pass that was commanded before it.
  void assign_shots() {
    std::size_t next = 0;
    std::int64_t strays = 0, first = 0;
    for (const Shot& s : world_->shots) {
      ++v_.triggered;
      v_.fired += s.outcome == Shot::Outcome::kFired;
      v_.missed += s.outcome == Shot::Outcome::kMissed;
      v_.ignored += s.outcome == Shot::Outcome::kIgnored;
      while (next < record_.orders.size() && record_.orders[next].t_us <= s.t_us) ++next;
      if (s.outcome == Shot::Outcome::kIgnored) continue;
      if (next == 0) {
        if (strays++ == 0) first = s.t_us;
      } else {
        const auto number = std::size_t(&s - world_->shots.data());
        auto& [from, to] = shots_[next - 1];
        if (to == 0) from = number;
        to = number + 1;
      }
    }
    if (strays)
      add(ViolationKind::kNotCommanded,
          std::to_string(strays) + " droplets before any pass was commanded, the first" + at(first));
  }

  void check_shots(std::size_t n, std::vector<bool>& fired) {
    const PassOrder& o = record_.orders[n];
    place_.resize(std::max(place_.size(), o.grid.size()), -1);
    for (std::size_t k = o.cells.size(); k-- > 0;) place_.at(o.cells[k]) = std::int32_t(k);
    fired.resize(std::max(fired.size(), o.grid.size()));
    std::vector<bool> triggered(o.cells.size());
    std::int64_t shots = 0;
    for (std::size_t k = shots_[n].first; k < shots_[n].second; ++k) {
      const Shot& s = world_->shots[k];
      ++v_.compared;
      if (!obeyed(s)) continue;
      ++shots;
      const auto [i, j] = cell_under(o, s);
      const bool on_grid = o.grid.contains(i, j);
      const std::uint32_t c = on_grid ? std::uint32_t(o.grid.index(i, j)) : 0;
      if (!on_grid || place_[c] < 0) {
        add(ViolationKind::kCellNotCommanded, pass_name(o) + ": a droplet on cell (" + std::to_string(i) +
                                                  ", " + std::to_string(j) + "), which was not commanded" +
                                                  at(s.t_us));
        continue;
      }
      triggered[std::size_t(place_[c])] = true;
      if (fired[c])
        add(ViolationKind::kCellTwice,
            pass_name(o) + ": a second droplet on " + cell(o.grid, c) + at(s.t_us));
      fired[c] = true;
      check_place(o, s, c);
      check_ink(o, s, c);
      check_wet(o, s, c);
      if (std::int64_t(s.exposures) < o.layer - 1)
        add(ViolationKind::kNotCured, pass_name(o) + ": a droplet on " + cell(o.grid, c) + " after " +
                                          std::to_string(s.exposures) + " exposures" + at(s.t_us));
    }
    for (const std::uint32_t c : o.cells) place_[c] = -1;
    const PassReport* r = index_.report_of(o);
    if (given_again(n)) {
      if (shots > 0)
        add(ViolationKind::kCellNotReported,
            pass_name(o) + ": " + std::to_string(shots) +
                " droplets of a command that was given again as if it had been refused");
      return;
    }
    if (!r) return;
    for (std::size_t k = 0; k < o.cells.size(); ++k) {
      if (std::int64_t(k) < r->unknown_from && !triggered[k])
        add(ViolationKind::kCellNotTriggered,
            pass_name(o) + ": " + cell(o.grid, o.cells[k]) + " is reported as done but was not triggered");
      if (std::int64_t(k) >= r->unknown_to && triggered[k])
        add(ViolationKind::kCellNotReported,
            pass_name(o) + ": " + cell(o.grid, o.cells[k]) + " was triggered but is reported as not done");
    }
  }

  // Returns the cell that a droplet was for: the one under the nozzle, or, where droplets are beside the
  // centres, that whose droplet is commanded nearest to the stage's place.
  std::pair<int, int> cell_under(const PassOrder& o, const Shot& s) const {
    std::pair<int, int> nearest{s.i, s.j};
    if (o.places.empty()) return nearest;
    const int i0 = int(std::lround((s.x_mm - o.grid.origin_x_mm) / o.grid.pitch_x_mm)),
              j0 = int(std::lround((s.y_mm - o.grid.origin_y_mm) / o.grid.pitch_y_mm));
    double least_mm2 = std::numeric_limits<double>::infinity();
    for (int j = j0 - 1; j <= j0 + 1; ++j)
      for (int i = i0 - kReach; i <= i0 + kReach; ++i) {
        if (!o.grid.contains(i, j) || place_[o.grid.index(i, j)] < 0) continue;
        const StagePlace& at = o.places[std::size_t(place_[o.grid.index(i, j)])];
        const double mm2 = (at.x_mm - s.x_mm) * (at.x_mm - s.x_mm) + (at.y_mm - s.y_mm) * (at.y_mm - s.y_mm);
        if (mm2 < least_mm2) {
          least_mm2 = mm2;
          nearest = {i, j};
        }
      }
    return nearest;
  }

  // The place that the droplet reached, less the lead, is nearer to the commanded one than to any other of
  // the table.
  void check_place(const PassOrder& o, const Shot& s, std::uint32_t c) {
    if (o.places.empty()) return;
    const Offset wanted = o.placement.of(c);
    const StagePlace& at = o.places[std::size_t(place_[c])];
    const Offset reached{wanted.x + (s.x_mm - at.x_mm) / o.grid.pitch_x_mm,
                         wanted.y + (s.y_mm - at.y_mm) / o.grid.pitch_y_mm};
    if (o.placement.table.nearest(reached) != o.placement.table.place(o.placement.map.of(c)))
      add(ViolationKind::kBesidePlace, pass_name(o) + ": a droplet on " + cell(o.grid, c) + " at (" +
                                           std::to_string(reached.x) + ", " + std::to_string(reached.y) +
                                           ") of the pitch instead of (" + std::to_string(wanted.x) + ", " +
                                           std::to_string(wanted.y) + ")" + firn::replay::at(s.t_us));
  }

  void check_ink(const PassOrder& o, const Shot& s, std::uint32_t c) {
    const PlannedLayer* plan = index_.plan_of(o);
    const Material wanted = plan && c < plan->materials.size() ? plan->materials.of(c) : Material::kA;
    if (s.ink != wanted)
      add(ViolationKind::kWrongInk,
          pass_name(o) + ": " + cell(o.grid, c) + " got a droplet of the other ink" + at(s.t_us));
  }

  // Between two cures all droplets of a layer lie in one sub-pattern.
  void check_wet(const PassOrder& o, const Shot& s, std::uint32_t c) {
    const PassPart* part = index_.part_of(o);
    if (!part || part->sub_patterns == 1) return;
    const int number = sub_pattern_of(int(c) % o.grid.nx, int(c) / o.grid.nx, part->sub_patterns);
    const auto [wet, first] = wet_.try_emplace(s.exposures, std::pair(o.layer, number));
    if (!first && wet->second.first == o.layer && wet->second.second != number)
      add(ViolationKind::kWetNeighbour, pass_name(o) + ": a droplet on " + cell(o.grid, c) +
                                            " while another sub-pattern of the layer is wet" + at(s.t_us));
  }

  static bool obeyed(const Shot& s) { return s.outcome != Shot::Outcome::kIgnored; }
  double wall_s(std::int64_t us) const { return double(us) * 1e-6 / options_.time_scale; }

  void check_stops() {
    constexpr auto kNever = std::numeric_limits<std::int64_t>::max();
    for (std::size_t n = 0; n < std::max<std::size_t>(1, record_.starts.size()); ++n) {
      const std::int64_t from = n < record_.starts.size() ? record_.starts[n] : 0;
      const std::int64_t to = n + 1 < record_.starts.size() ? record_.starts[n + 1] : kNever;
      const auto stop = std::ranges::lower_bound(record_.stops, std::int32_t(n), {}, &Stop::incarnation);
      if (stop == record_.stops.end() || stop->incarnation != std::int32_t(n)) continue;
      v_.stops += stop->t_us < record_.end_us;
      std::int64_t late = 0;
      double latest_s = 0.0;
      auto shot = std::max(std::ranges::upper_bound(world_->shots, stop->t_us, {}, &Shot::t_us),
                           std::ranges::lower_bound(world_->shots, from, {}, &Shot::t_us));
      for (; shot != world_->shots.end() && shot->t_us < to; ++shot) {
        const Shot& s = *shot;
        ++v_.compared;
        if (!obeyed(s)) continue;
        latest_s = wall_s(s.t_us - stop->t_us);
        late += latest_s > options_.stop_limit_s;
      }
      v_.longest_stop_s = std::max(v_.longest_stop_s, latest_s);
      if (late)
        add(ViolationKind::kAfterStop, std::to_string(late) + " droplets later than " +
                                           std::to_string(options_.stop_limit_s) + " s after the stop" +
                                           at(stop->t_us) + " (" + stop->cause + "), the last after " +
                                           std::to_string(latest_s) + " s");
    }
  }

  void check_leases() {
    std::size_t next = 0;
    std::int64_t count = 0, first = 0;
    for (const Shot& s : world_->shots) {
      while (next < record_.leases.size() && record_.leases[next].t_us <= s.t_us) ++next;
      if (!obeyed(s)) continue;
      const bool late =
          next == 0 || wall_s(s.t_us - record_.leases[next - 1].until_us) > options_.lease_limit_s;
      if (late && count++ == 0) first = s.t_us;
    }
    if (count)
      add(ViolationKind::kOutsideLease,
          std::to_string(count) + " droplets without a lease, the first" + at(first));
  }

  void check_disarmed() {
    std::size_t next = 0;
    bool armed[2] = {false, false}, told = false;
    std::int64_t count = 0, first = 0;
    for (const Shot& s : world_->shots) {
      for (; next < world_->jet.size() && (world_->jet[next].t_us < s.t_us ||
                                           (world_->jet[next].t_us == s.t_us && world_->jet[next].armed));
           ++next) {
        armed[world_->jet[next].ink == Material::kB] = world_->jet[next].armed;
        if (armed[0] && armed[1] && !std::exchange(told, true))
          add(ViolationKind::kBothArmed, "both jets were armed" + at(world_->jet[next].t_us));
      }
      if (obeyed(s) && !armed[s.ink == Material::kB] && count++ == 0) first = s.t_us;
    }
    if (count)
      add(ViolationKind::kDisarmed,
          std::to_string(count) + " droplets from a jet that was not armed, the first" + at(first));
  }

  void count_commanded() {
    std::set<std::pair<std::int32_t, std::int32_t>> counted;
    for (const PassOrder& o : record_.orders)
      if (counted.emplace(o.layer, o.pass).second) v_.commanded += std::int64_t(o.cells.size());
  }

  const AuditRecord& record_;
  const WorldTruth* world_;
  const AuditOptions& options_;
  AuditIndex index_;
  std::vector<std::pair<std::size_t, std::size_t>> shots_;  // by order: from, to in world_->shots
  std::vector<std::int32_t> place_;  // by cell: number in firing order; -1: not of the order
  std::map<std::uint32_t, std::pair<std::int32_t, int>>
      wet_;  // cures before -> layer and sub-pattern that is wet
  AuditVerdict v_;
};

}  // namespace

AuditVerdict audit(const AuditRecord& record, const WorldTruth* world, const AuditOptions& options) {
  return Audit(record, world, options).go();
}

}  // namespace firn::replay
