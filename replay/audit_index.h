// AuditIndex finds the report, the plan and the part of a pass in a time that does not grow with the print.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "replay/audit_record.h"

namespace firn::replay {

class AuditIndex {
 public:
  /// @param record must outlive the index
  explicit AuditIndex(const AuditRecord& record);

  /// Returns the first report of the pass since the order; nullptr without one.
  const PassReport* report_of(const PassOrder& order) const { return found(order).report; }
  /// Returns the plan that an order carries out: that of the reported map, or the last one before the order.
  const PlannedLayer* plan_of(const PassOrder& order) const { return found(order).plan; }
  /// Returns nullptr where a layer is one pattern of one ink, and for a pass that was never reported.
  const PassPart* part_of(const PassOrder& order) const { return found(order).part; }
  /// Returns the number of passes that the plan's layer is printed in.
  std::int32_t passes_of(const PlannedLayer& plan) const;
  /// Returns the orders of a layer, in order of time.
  const std::vector<std::size_t>& orders_of(std::int32_t layer) const { return orders_.at(layer); }
  /// Returns the first order later than a time; the number of orders without one.
  std::size_t order_after(std::int64_t t_us) const;
  /// Returns the first map, in the order of the record, that was measured later; nullptr without one.
  const MeasuredMap* map_after(std::int64_t t_us) const;
  /// Returns true if a map of this number was measured later.
  bool measured_after(std::int64_t map_id, std::int64_t t_us) const;

  /// Returns the number of entries of the record that were compared to build the index.
  std::uint64_t compared() const { return compared_; }

 private:
  using Pass = std::tuple<std::int32_t, std::int32_t, std::int32_t>;  // layer, attempt, pass
  struct Found {
    const PassReport* report = nullptr;
    const PlannedLayer* plan = nullptr;
    const PassPart* part = nullptr;
  };
  const Found& found(const PassOrder& order) const {
    return found_[std::size_t(&order - record_.orders.data())];
  }

  const AuditRecord& record_;
  std::vector<Found> found_;  // by order
  std::map<std::int32_t, std::vector<std::size_t>> orders_;
  std::map<std::int32_t, std::int32_t> passes_;             // by layer, as its first part says
  std::vector<std::int64_t> latest_order_us_, sampled_us_;  // maximum of the entries so far
  std::map<std::int64_t, std::int64_t> map_sampled_us_;     // the latest by map_id
  std::uint64_t compared_ = 0;
};

}  // namespace firn::replay
