// Compares two encoded messages of one channel, field by field where their bytes differ.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/channels.h"
#include "lcmtypes/schema.h"
#include "replay/options.h"
#include "replay/verdict.h"

namespace firn::replay {

/// Holds the tolerance and the ignored fields, and counts the differences that both let pass.
class MessageComparer {
 public:
  explicit MessageComparer(const ReplayOptions& options);

  /// Returns the first field that differs and is neither ignored nor within the tolerance.
  std::optional<FieldDifference> compare(const ChannelInfo& channel, std::span<const std::byte> a,
                                         std::span<const std::byte> b);

  const std::vector<Ignored>& ignored() const { return ignored_; }
  double largest_difference() const { return largest_; }
  const std::string& largest_difference_field() const { return largest_field_; }

 private:
  bool ignores(std::string_view channel, std::string_view path);
  bool within_tolerance(std::string_view channel, const Leaf& a, const LeafValue& b);

  double tolerance_;
  std::vector<Ignored> ignored_;
  double largest_ = 0.0;
  std::string largest_field_;
  struct Value {
    LeafValue value;
    std::size_t offset, bytes;
  };
  std::vector<Value> values_;  // of one message; storage used again
};

/// Returns the first byte that differs, as "byte 12" with both values in hex, "end" behind the end.
FieldDifference byte_difference(std::span<const std::byte> a, std::span<const std::byte> b);

}  // namespace firn::replay
