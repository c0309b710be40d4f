// Checks of the rules between the keys of one experiment, a function a lab.
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "config/checks.h"
#include "config/fields.h"

namespace firn {

/// Holds an experiment and the places where its keys were set; reports the first rule that is broken.
class Rules {
 public:
  /// @param all gets an error for every rule that is broken; null: the first is thrown
  Rules(const Experiment& experiment, const Origins& origins, const std::string& file,
        std::vector<ConfigError>* all = nullptr);

  Experiment& experiment() { return experiment_; }
  const Experiment& experiment() const { return experiment_; }

  /// The value of a key as text, with its unit.
  std::string value(const std::string& key) const;

  /// @param keys the first is named; its origin, or that of the first one set at all, is the place
  /// @throws ConfigError unless ok
  void require(bool ok, std::initializer_list<const char*> keys, const std::string& problem) const;
  void at_most(const char* key, double actual, const char* limit_key, double limit) const;
  void below(const char* low_key, double low, const char* high_key, double high) const;

  /// @throws ConfigError unless the lab's table of control schemes has control.scheme
  template <class Scheme>
  void scheme_of(std::span<const Scheme> schemes) const {
    std::string names;
    bool known = false;
    for (const Scheme& s : schemes) {
      names += (names.empty() ? "" : ", ") + std::string(s.name);
      known = known || s.name == experiment_.control.scheme;
    }
    require(known, {"control.scheme", "lab.kind"}, "lab.kind = " + value("lab.kind") + " knows " + names);
  }

 private:
  Experiment experiment_;
  std::vector<Field> table_;
  const Origins& origins_;
  std::string file_;
  std::vector<ConfigError>* all_;
};

/// Checks that the soft limits of the stage leave it a travel, and the height of the nozzle in it.
void check_stage_travel(const Rules& rules);
/// Checks the speed of the profiler's scan: the stage reaches it within one row; and that of a point what
/// such an instrument can do.
void check_scan_speed(const Rules& rules);

/// Checks the limits of a point laser that the stage moves. @pre has_point_scan
void check_point_scan(const Rules& rules);

void check_inkjet_lab(Rules& rules);
void check_ice_lab(Rules& rules);

}  // namespace firn
