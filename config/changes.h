// Changes holds the operator's changes of a print's options while it runs, as every node that reads them
// applies them.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "config/experiment.h"

namespace firn {

/// Returns "" if `key` may be set to `value` between two layers of this print, else the problem, which names
/// key and limit.
std::string change_problem(const Experiment& experiment, const std::string& key, const std::string& value);

/// Returns "" if the scheme of this print reads `key`, or the key is none of a scheme's, else the reason: "is
/// of scheme smf, and this print has scheme mpc".
std::string unread_by_scheme(const Experiment& experiment, std::string_view key);

/// Returns the keys that may change between layers of this print (Change::kBetweenLayers), separated by ", ".
std::string changeable_keys(const Experiment& experiment);

/// Applies each command once: a command that arrives a second time has the same number.
class Changes {
 public:
  explicit Changes(const Experiment& experiment) : experiment_(experiment) {}

  const Experiment& experiment() const { return experiment_; }
  /// Returns true if no command of this number was taken before. Number 0 is always new.
  bool take(std::int64_t command_id) { return command_id == 0 || taken_.insert(command_id).second; }
  /// Sets the value. Returns "" or, with nothing changed, the problem.
  std::string set(const std::string& key, const std::string& value);

 private:
  Experiment experiment_;
  std::set<std::int64_t> taken_;
};

}  // namespace firn
