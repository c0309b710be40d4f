// The audit's verdict as text and as JSON.
#include <cstdio>

#include "core/options/for_people.h"
#include "files/json.h"
#include "replay/audit.h"
#include "replay/print_verdict.h"

namespace firn::replay {
namespace {

constexpr std::size_t kViolationsTold = 20;

std::string range(const Unknown& u, bool paths) {
  if (paths) return "layer " + std::to_string(u.layer) + ", path " + std::to_string(u.pass);
  return "layer " + std::to_string(u.layer) + ", pass " + std::to_string(u.pass + 1) +
         (u.attempt ? ", attempt " + std::to_string(u.attempt) : "") + ", droplets " +
         std::to_string(u.from) + " to " + std::to_string(u.to);
}

}  // namespace

const char* word(ViolationKind kind) {
  switch (kind) {
    case ViolationKind::kSkippedLayer:
      return "layer skipped";
    case ViolationKind::kLayerTwice:
      return "layer deposited twice";
    case ViolationKind::kSkippedPass:
      return "pass skipped";
    case ViolationKind::kOtherCells:
      return "other cells than planned";
    case ViolationKind::kNoReport:
      return "no report";
    case ViolationKind::kUnresolved:
      return "doubt not resolved";
    case ViolationKind::kCellTwice:
      return "cell deposited twice";
    case ViolationKind::kBesidePlace:
      return "beside its place";
    case ViolationKind::kOtherSize:
      return "other size of droplet";
    case ViolationKind::kCellNotCommanded:
      return "cell not commanded";
    case ViolationKind::kCellNotTriggered:
      return "cell not triggered";
    case ViolationKind::kCellNotReported:
      return "cell not reported";
    case ViolationKind::kNotCommanded:
      return "nothing commanded";
    case ViolationKind::kAfterStop:
      return "fired after a stop";
    case ViolationKind::kOutsideLease:
      return "fired without a lease";
    case ViolationKind::kDisarmed:
      return "fired while disarmed";
    case ViolationKind::kNotCured:
      return "layer not cured";
    case ViolationKind::kWetNeighbour:
      return "wet neighbours";
    case ViolationKind::kWrongInk:
      return "wrong ink";
    case ViolationKind::kBothArmed:
      return "both jets armed";
    case ViolationKind::kPathTwice:
      return "path deposited twice";
    case ViolationKind::kDamaged:
      return "damaged record";
    case ViolationKind::kAltered:
      return "altered after the seal";
    case ViolationKind::kForged:
      return "forged message";
    case ViolationKind::kOtherTruth:
      return "other truth than the world's";
  }
  return "";
}

std::string to_text(const AuditVerdict& v) {
  std::string s = v.clean() ? "clean: " : counted(v.violations_total, "violation") + ": ";
  s += counted(std::uint64_t(v.layers), "layer") + ", " +
       (v.paths ? counted(std::uint64_t(v.passes), "path")
                : counted(std::uint64_t(v.passes), "pass", "passes")) +
       ", " + counted(std::uint64_t(v.commanded), v.paths ? "pulse" : "droplet") + " commanded";
  if (v.with_world && v.paths)
    s += ", " + grouped(std::uint64_t(v.fired)) + " fired";
  else if (v.with_world)
    s += ", " + grouped(std::uint64_t(v.triggered)) + " triggered, " + grouped(std::uint64_t(v.fired)) +
         " fired, " + grouped(std::uint64_t(v.missed)) + " missed by the nozzle, " +
         grouped(std::uint64_t(v.ignored)) + " ignored by the jet";
  else
    s += v.real ? " (the nodes' own records alone: real instruments took part)"
                : " (no world.rec: the nodes' own records alone)";
  if (!v.finished) s += "; the run has not finished";
  s += "\n";
  if (!v.seal.empty()) s += v.seal + "\n";
  for (const std::string& n : v.notes) s += "note: " + n + "\n";
  for (const std::string& o : v.operator_orders) s += "operator: " + o + "\n";
  for (const Unknown& u : v.unknowns)
    s += "unknown: " + range(u, v.paths) + ": " +
         (u.resolved_by ? "resolved by the scan of map " + std::to_string(*u.resolved_by) : "open") + "\n";
  if (v.stops && v.with_world) {
    char text[96];
    std::snprintf(text, sizeof text, "stops: %lld, the last %s %.3f s after a fault\n",
                  static_cast<long long>(v.stops), v.paths ? "pulse" : "droplet", v.longest_stop_s);
    s += text;
  }
  for (std::size_t n = 0; n < v.violations.size() && n < kViolationsTold; ++n)
    s += std::string(word(v.violations[n].kind)) + ": " + v.violations[n].what + "\n";
  if (v.violations_total > kViolationsTold)
    s += "and " + grouped(v.violations_total - kViolationsTold) + " more\n";
  return s;
}

std::string audit_words(const AuditVerdict& v) {
  if (v.clean()) return v.with_world ? "clean" : "clean, without the world's record";
  return grouped(v.violations_total) + (v.violations_total == 1 ? " violation: " : " violations: ") +
         v.violations.front().what;
}

std::string to_json(const AuditVerdict& v) {
  using Json = nlohmann::ordered_json;
  Json j{{"clean", v.clean()},
         {"finished", v.finished},
         {"with_world", v.with_world},
         {"layers", v.layers},
         {"passes", v.passes},
         {"commanded", v.commanded},
         {"triggered", v.triggered},
         {"fired", v.fired},
         {"missed", v.missed},
         {"ignored", v.ignored},
         {"stops", v.stops},
         {"longest_stop_s", v.longest_stop_s},
         {"violations_total", v.violations_total}};
  j["seal"] = v.seal;
  j["notes"] = v.notes;
  j["operator"] = v.operator_orders;
  j["unknowns"] = Json::array();
  for (const Unknown& u : v.unknowns) {
    j["unknowns"].push_back(
        {{"layer", u.layer}, {"pass", u.pass}, {"attempt", u.attempt}, {"from", u.from}, {"to", u.to}});
    j["unknowns"].back()["resolved_by_map"] = u.resolved_by ? Json(*u.resolved_by) : Json();
  }
  j["violations"] = Json::array();
  for (const Violation& x : v.violations)
    j["violations"].push_back({{"kind", word(x.kind)}, {"what", x.what}});
  return j.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace firn::replay
