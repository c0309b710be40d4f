#include "replay/audit_index.h"

#include <algorithm>

namespace firn::replay {
namespace {

template <class Entry>
std::tuple<std::int32_t, std::int32_t, std::int32_t> pass_of(const Entry& entry) {
  return {entry.layer, entry.attempt, entry.pass};
}

}  // namespace

AuditIndex::AuditIndex(const AuditRecord& record) : record_(record), found_(record.orders.size()) {
  std::map<Pass, std::vector<const PassReport*>> reports;
  std::map<Pass, const PassPart*> parts;
  std::map<std::int32_t, std::vector<const PlannedLayer*>> plans;
  for (const PassReport& r : record.reports) reports[pass_of(r)].push_back(&r);
  for (const PassPart& p : record.parts) {
    parts.try_emplace(pass_of(p), &p);
    passes_.try_emplace(p.layer, p.passes);
  }
  for (const PlannedLayer& p : record.plans) plans[p.layer].push_back(&p);
  for (std::size_t n = 0; n < found_.size(); ++n) {
    const PassOrder& o = record.orders[n];
    Found& f = found_[n];
    orders_[o.layer].push_back(n);
    const std::vector<const PassReport*>& of_pass = reports[pass_of(o)];
    const auto report = std::ranges::find_if(of_pass, [&](const PassReport* r) {
      ++compared_;
      return r->t_us >= o.t_us;
    });
    if (report != of_pass.end()) f.report = *report;
    for (const PlannedLayer* p : plans[o.layer]) {
      ++compared_;
      if (p->t_us <= o.t_us && (!f.report || p->map_id == f.report->map_id)) f.plan = p;
    }
    if (const auto part = parts.find(pass_of(o)); part != parts.end()) f.part = part->second;
  }
  const auto maximum_so_far = [](std::vector<std::int64_t>& values, std::int64_t value) {
    values.push_back(values.empty() ? value : std::max(values.back(), value));
  };
  for (const PassOrder& o : record.orders) maximum_so_far(latest_order_us_, o.t_us);
  for (const MeasuredMap& m : record.maps) {
    maximum_so_far(sampled_us_, m.sample_us);
    const auto [latest, first] = map_sampled_us_.try_emplace(m.map_id, m.sample_us);
    if (!first) latest->second = std::max(latest->second, m.sample_us);
  }
}

std::int32_t AuditIndex::passes_of(const PlannedLayer& plan) const {
  const auto passes = passes_.find(plan.layer);
  return passes == passes_.end() ? plan.passes : passes->second;
}

std::size_t AuditIndex::order_after(std::int64_t t_us) const {
  return std::size_t(std::ranges::upper_bound(latest_order_us_, t_us) - latest_order_us_.begin());
}

const MeasuredMap* AuditIndex::map_after(std::int64_t t_us) const {
  const auto n = std::size_t(std::ranges::upper_bound(sampled_us_, t_us) - sampled_us_.begin());
  return n < record_.maps.size() ? &record_.maps[n] : nullptr;
}

bool AuditIndex::measured_after(std::int64_t map_id, std::int64_t t_us) const {
  const auto sampled = map_sampled_us_.find(map_id);
  return sampled != map_sampled_us_.end() && sampled->second > t_us;
}

}  // namespace firn::replay
