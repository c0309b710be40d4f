#include "replay/audit_record.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/grid/firing_order.h"
#include "core/options/enumerators.h"
#include "firn/deposition_report_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/jet_command_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/convert.h"
#include "runs/read/run_reader.h"

namespace firn::replay {
namespace {

DropletPattern pattern(const grid_t& grid, const std::vector<std::int8_t>& drops) {
  DropletPattern p(from_message(grid));
  if (drops.size() == p.size()) p.cells.assign(drops.begin(), drops.end());
  return p;
}

PassOrder order_of(const stage_command_t& m, const OffsetTable& places, AuditRecord& r) {
  const DropletPattern fires = pattern(m.grid, m.fires);
  PassOrder o{m.header.utime_us, m.layer, m.attempt, m.pass_index, fires.spec, {}};
  o.placement = placement_of(m, places);
  try {
    check(o.placement, fires.spec);
  } catch (const std::invalid_argument& why) {
    r.damage.push_back("STAGE_COMMAND of layer " + std::to_string(m.layer) + ": " + why.what());
    o.placement = {};
  }
  for (const FiringRun& run : firing_runs(fires, 0, o.placement))
    for (const std::uint32_t c : run.cells) {
      o.cells.push_back(c);
      if (!o.placement.map.cells.empty())
        o.places.push_back(stage_place(fires.spec, int(c % std::uint32_t(fires.spec.nx)), run.row,
                                       o.placement.of(c), {.lead_mm = m.lead_mm}, run.towards_plus_x));
    }
  return o;
}

std::string in_words(const operator_command_t& m) {
  constexpr const char* kVerbs[] = {"accept-doubt", "pause", "continue", "finish-layer", "stop", "set"};
  static_assert(std::size(kVerbs) + 1 == kTableSize<OperatorVerb>);
  const int verb = std::clamp(int(m.verb), 1, int(std::size(kVerbs)));
  char time[32];
  std::snprintf(time, sizeof time, " at %.3f s", double(m.header.utime_us) * 1e-6);
  return kVerbs[verb - 1] + (m.key.empty() ? "" : " " + m.key + "=" + m.value) + time;
}

}  // namespace

std::vector<std::string> operator_orders(const runs::RunReader& messages) {
  std::vector<std::string> orders;
  messages.each<operator_command_t>(channels::kOperatorCommand.name,
                                    [&](const operator_command_t& m) { orders.push_back(in_words(m)); });
  return orders;
}

AuditRecord read_audit_record(const std::filesystem::path& run, const OffsetTable& places) {
  const runs::RunReader messages(run);
  AuditRecord r;
  messages.each<stage_command_t>(channels::kStageCommand.name, [&](const stage_command_t& m) {
    if (StageVerb(m.verb) != StageVerb::kPass) return;
    r.orders.push_back(order_of(m, places, r));
  });
  messages.each<layer_plan_t>(channels::kLayerPlan.name, [&](const layer_plan_t& m) {
    if (PlanDecision(m.decision) == PlanDecision::kPrint)
      r.plans.push_back({m.header.utime_us, m.layer, m.passes, m.map_id, pattern(m.grid, m.drops),
                         materials_of(m), offsets_of(m)});
  });
  // Layer and map of a plan of two inks, or of two sizes of droplet.
  std::set<std::pair<std::int32_t, std::int64_t>> in_parts;
  for (const PlannedLayer& plan : r.plans)
    if (!plan.materials.cells.empty() ||
        std::ranges::any_of(plan.offsets.cells, [&](std::uint8_t place) { return places.small(place); }))
      in_parts.emplace(plan.layer, plan.map_id);
  if (places.places() < places.size())
    messages.each<jet_command_t>(channels::kJetCommand.name, [&](const jet_command_t& m) {
      if (JetVerb(m.verb) == JetVerb::kArm || JetVerb(m.verb) == JetVerb::kArmSmall)
        r.arms.push_back({m.header.utime_us, JetVerb(m.verb) == JetVerb::kArmSmall});
    });
  messages.each<deposition_report_t>(channels::kDepositionReport.name, [&](const deposition_report_t& m) {
    r.reports.push_back(
        {m.header.utime_us, m.layer, m.attempt, m.pass_index, m.map_id, m.unknown_from, m.unknown_to});
    if (m.sub_patterns > 1 || in_parts.contains({m.layer, m.map_id}))
      r.parts.push_back({m.layer, m.attempt, m.pass_index, m.passes, m.round, m.sub_pattern, m.sub_patterns,
                         Material(m.material)});
  });
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    r.maps.push_back({m.header.utime_us, m.layer, m.map_id, m.sample_utime_us});
  });
  messages.each<safe_stop_t>(channels::kSafeStop.name, [&](const safe_stop_t& m) {
    r.stops.push_back({m.header.utime_us, m.cause, m.header.incarnation});
  });
  for (const NodeInfo& node : nodes())
    messages.each<fault_t>(channels::fault(node.id).name, [&](const fault_t& m) {
      if (Severity(m.severity) == Severity::kStop)
        r.stops.push_back({m.header.utime_us, m.node + ": " + m.text, m.header.incarnation});
    });
  messages.each<enable_t>(channels::kEnable.name, [&](const enable_t& m) {
    const std::int64_t t = m.header.utime_us;
    const std::int64_t before = r.leases.empty() ? t : std::min(t, r.leases.back().until_us);
    r.leases.push_back({t, m.enabled ? Time{t}.after_s(m.lease_s).us : before});
  });
  messages.each<run_end_t>(channels::kRunEnd.name, [&](const run_end_t& m) {
    r.finished =
        RunOutcome(m.outcome) == RunOutcome::kFinished || RunOutcome(m.outcome) == RunOutcome::kEndedEarly;
    r.end_us = r.finished ? m.header.utime_us : AuditRecord{}.end_us;
  });
  r.operator_orders = operator_orders(messages);
  std::ranges::stable_sort(r.stops, {}, [](const Stop& s) { return std::pair(s.incarnation, s.t_us); });
  r.starts = messages.starts();
  const std::vector<std::string> damage = messages.damage();
  r.damage.insert(r.damage.begin(), damage.begin(), damage.end());
  r.forged = messages.forged();
  return r;
}

}  // namespace firn::replay
