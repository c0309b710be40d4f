// Compares the deposited droplets with the plan: the lab must deposit the planned droplets, each at most
// once, and no droplet after a stop. The audit compares the nodes' records with the true events in the
// simulated world. It reads no file: audit_record.h reads the nodes' records; cli/audit_command.cpp, which
// alone may know the world's format, reads the world's own record.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "replay/audit_record.h"

namespace firn::replay {

/// Holds a trigger pulse that reached the jet.
struct Shot {
  enum class Outcome : std::uint8_t {
    kFired,
    kMissed,   ///< the jet obeyed, no droplet came
    kIgnored,  ///< the jet did not obey
  };
  std::int64_t t_us = 0;
  std::int32_t i = 0, j = 0;    ///< cell under the nozzle, as the lab believed
  std::uint32_t exposures = 0;  ///< cures before
  Outcome outcome = Outcome::kFired;
  Material ink = Material::kA;    ///< of the jet that was triggered
  double x_mm = 0.0, y_mm = 0.0;  ///< of the stage
};

/// Holds the world's own record, in order of time.
struct WorldTruth {
  struct Switch {
    std::int64_t t_us = 0;
    bool armed = false;
    Material ink = Material::kA;
  };
  std::vector<Shot> shots;
  std::vector<Switch> jet;    ///< external triggers of a jet on, off
  std::uint64_t damaged = 0;  ///< places where the record is damaged
};

struct AuditOptions {
  double time_scale = 1.0;               ///< node seconds per second of wall time
  double stop_limit_s = 1.0;             ///< wall time from the first fault to the last droplet
  double lease_limit_s = 0.05;           ///< wall time from the end of the lease to the last droplet
  std::vector<std::string> damage = {};  ///< of the run folder, as the caller found it
};

enum class ViolationKind : std::uint8_t {
  kSkippedLayer,  ///< layers are not 1, 2, 3, …
  kLayerTwice,    ///< a layer was begun again, or planned from two maps
  kSkippedPass,   ///< left out or left incomplete, though nothing was in doubt
  kOtherCells,    ///< the stage was sent to other cells than planned
  kNoReport,      ///< the print went on without a report of the pass
  kUnresolved,    ///< droplets in doubt, and no scan before the next ones
  kCellTwice,
  kCellNotCommanded,
  kBesidePlace,       ///< not at the cell's place inside it
  kOtherSize,         ///< the jet was armed for droplets of another size
  kCellNotTriggered,  ///< though reported as done
  kCellNotReported,   ///< triggered though reported as not done
  kNotCommanded,      ///< fired before anything was commanded
  kAfterStop,
  kOutsideLease,
  kDisarmed,
  kNotCured,      ///< fired on a layer that was not cured
  kWetNeighbour,  ///< two sub-patterns of a layer without a cure between
  kWrongInk,      ///< another jet than that of the cell's ink
  kBothArmed,     ///< two jets at a time
  kPathTwice,     ///< a path was run twice, or reported twice
  kDamaged,       ///< a record cannot be trusted
  kAltered,       ///< the run folder is not as it was sealed
  kForged,        ///< a node received a message that its publisher did not send
  kOtherTruth,    ///< the log's truth is not that of the world's record
};
const char* word(ViolationKind kind);

struct Violation {
  ViolationKind kind{};
  std::string what;  ///< one sentence with layer, pass, cell, time
};

/// Holds droplets in doubt: the records do not show if they were fired.
struct Unknown {
  std::int32_t layer = 0, attempt = 0, pass = 0;
  std::int64_t from = 0, to = 0;  ///< in firing order
  std::int64_t t_us = 0;
  std::optional<std::int64_t> resolved_by;  ///< map_id of the scan after it; empty: the run ended before
};

struct AuditVerdict {
  std::int64_t layers = 0, passes = 0;
  std::int64_t commanded = 0;  ///< droplets, once per layer, pass and cell
  std::int64_t triggered = 0, fired = 0, missed = 0, ignored = 0;
  std::int64_t stops = 0;       ///< incarnations that ended in a stop
  double longest_stop_s = 0.0;  ///< wall time from a first fault to the last droplet after it; 0: no droplet
  bool finished = false;        ///< reported by RUN_END
  bool with_world = false;
  bool real = false;   ///< instruments outside the simulated world took part: its record is not the truth
  bool paths = false;  ///< of a path printer: passes are paths, droplets are pulses
  std::vector<Unknown> unknowns;
  std::vector<Violation> violations;  ///< at most kKept
  std::uint64_t violations_total = 0;
  std::uint64_t compared = 0;  ///< entries of the records that were looked at: grows as the print does
  std::vector<std::string> operator_orders;  ///< "pause at 12.345 s"
  std::string seal;                          ///< "sealed: 2 seals, 31 files, <digest>"; empty: not looked at
  std::vector<std::string> notes;            ///< parts of the run for which a check is not possible
  static constexpr std::size_t kKept = 100;

  void add(ViolationKind kind, std::string what) {
    ++violations_total;
    if (violations.size() < kKept) violations.push_back({kind, std::move(what)});
  }
  bool clean() const { return violations_total == 0; }
};

/// Returns the verdict of the audit.
/// @param world nullptr if there is no record of the truth (a real lab): only the nodes' own records are
/// checked
AuditVerdict audit(const AuditRecord& record, const WorldTruth* world, const AuditOptions& options);

std::string to_text(const AuditVerdict& verdict);
/// Returns "clean", "clean, without the world's record", or the number of violations and the first.
std::string audit_words(const AuditVerdict& verdict);
std::string to_json(const AuditVerdict& verdict);

}  // namespace firn::replay
