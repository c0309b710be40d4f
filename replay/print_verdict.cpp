#include "replay/print_verdict.h"

#include <cstdio>

#include "core/options/for_people.h"
#include "files/json.h"

namespace firn::replay {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPlacesTold = 10;

std::string seconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", double(ns) * 1e-9);
  return text;
}

std::string place(const Finding& f) {
  std::string s = f.node;
  if (f.step) s += (s.empty() ? "step " : ", step ") + std::to_string(*f.step);
  if (!f.channel.empty()) s += ", " + f.channel;
  if (f.seq) s += " " + std::to_string(*f.seq);
  if (!f.field.empty()) s += ", field " + f.field;
  return s;
}

std::string values(const Finding& f) {
  if (f.field.empty()) return "";
  switch (f.kind) {
    case FindingKind::kDelivery:
      return "sent " + f.recorded + ", delivered " + f.replayed;
    case FindingKind::kLog:
      return "write-ahead file " + f.recorded + ", log.lcm " + f.replayed;
    default:
      return "recorded " + f.recorded + ", replayed " + f.replayed;
  }
}

std::string full(const Finding& f) {
  std::string s = "  " + place(f) + "\n";
  if (!f.field.empty()) s += "  " + values(f) + "\n";
  s += "  " + f.what + "\n";
  if (f.inputs.empty()) return s;
  s += "  the node's last inputs:\n";
  for (const std::string& i : f.inputs) s += "    " + i + "\n";
  return s;
}

std::string one_line(const Finding& f) {
  const std::string v = values(f);
  return "  " + place(f) + ": " + (v.empty() ? f.what : v) + "\n";
}

std::string counts(const RunVerdict& v) {
  std::uint64_t steps = 0, messages = 0, bytes = 0;
  for (const NodeVerdict& n : v.nodes) {
    steps += n.steps;
    messages += n.messages;
    bytes += n.bytes;
  }
  return std::to_string(v.nodes.size()) + (v.nodes.size() == 1 ? " node, " : " nodes, ") + grouped(steps) +
         " steps, " + grouped(messages) + " messages (" + grouped(bytes) + " bytes)";
}

Json as_json(const Finding& f) {
  Json j{{"kind", word(f.kind)}, {"node", f.node}, {"time_us", f.at.us}, {"what", f.what}};
  if (f.step) j["step"] = *f.step;
  if (!f.channel.empty()) j["channel"] = f.channel;
  if (f.seq) j["seq"] = *f.seq;
  if (!f.field.empty()) {
    j["field"] = f.field;
    j["recorded"] = f.recorded;
    j["replayed"] = f.replayed;
  }
  if (!f.inputs.empty()) {
    j["inputs"] = Json::array();
    for (const std::string& i : f.inputs) {
      const Json input = Json::parse(i, nullptr, false);
      j["inputs"].push_back(input.is_discarded() ? Json(i) : input);
    }
  }
  return j;
}

Json as_json(const NodeVerdict& n) {
  Json j{{"node", n.name},
         {"incarnations", n.incarnations},
         {"steps", n.steps},
         {"messages_in", n.events_in},
         {"messages", n.messages},
         {"bytes", n.bytes},
         {"cut", n.cut},
         {"differing_steps", n.differing_steps},
         {"decisions", n.decisions},
         {"differing_decisions", n.differing_decisions},
         {"differing_cells", n.differing_cells},
         {"recorded_handler_s", double(n.recorded_handler_ns) * 1e-9}};
  if (!n.crash.empty()) j["crash"] = n.crash;
  return j;
}

}  // namespace

std::string to_text(const RunVerdict& v) {
  std::string s;
  for (const std::string& p : v.provenance) s += "provenance differs: " + p + "\n";
  for (const std::string& c : v.changed_settings) s += "changed setting: " + c + "\n";
  for (const std::string& n : v.notes) s += "note: " + n + "\n";
  for (const NodeVerdict& n : v.not_replayed)
    s += "not replayed: " + n.name + ": " + n.python +
         " is code of the run, which this user on this host did not print so; --run-python runs it\n";
  for (std::size_t n = 0; n < v.altered.size() && n < kPlacesTold; ++n)
    s += "altered after the seal: " + v.altered[n] + "\n";
  if (v.altered.size() > kPlacesTold)
    s += "altered after the seal: " + grouped(v.altered.size() - kPlacesTold) + " more places\n";
  for (const Ignored& i : v.ignored)
    s += "ignored: " + i.field + " (" + i.reason + "), " + grouped(i.times) + " differences\n";
  for (const NodeVerdict& n : v.nodes) {
    if (n.cut)
      s += n.name + ": outputs of " + std::to_string(n.cut) +
           " steps were cut off by a kill and not compared\n";
    if (!n.crash.empty()) s += n.name + ": the handler throws where the run ended, " + n.crash + "\n";
  }
  for (std::size_t n = 0; n < v.damage.size() && n < kPlacesTold; ++n) {
    const DamagedPlace& d = v.damage[n];
    s += "damaged: " + d.file + ", byte " + std::to_string(d.offset) + ": " + d.reason +
         (d.step ? ", step " + std::to_string(*d.step) : "") + "\n";
  }
  if (v.damage.size() > kPlacesTold)
    s += "damaged: " + grouped(v.damage.size() - kPlacesTold) + " more places\n";

  for (const NodeVerdict& n : v.nodes)
    if (!v.changed_settings.empty() && n.decisions > 0)
      s += "decisions: " + grouped(n.differing_decisions) + " of " + grouped(n.decisions) + " differ, in " +
           grouped(n.differing_cells) + " cells\n";
  if (v.tolerance > 0) {
    char text[64];
    std::snprintf(text, sizeof text, "largest difference %g", v.largest_difference);
    s += std::string(text) + (v.largest_difference > 0 ? " (" + v.largest_difference_field + ")" : "") + "\n";
  }
  if (v.identical()) {
    s += "identical: " + counts(v);
    if (v.log_present) s += ", log.lcm " + grouped(v.log_messages) + " messages";
    return s + ", " + seconds(v.wall_ns) + "\n";
  }
  if (v.findings.empty())
    return s + "not identical: " + (v.damage.empty() ? "altered" : "damaged") +
           " files; what could be read agrees: " + counts(v) + "\n";
  s += (v.exit_status() == 2 ? "cannot replay:\n" : "first divergence:\n") + full(v.findings.front());
  if (v.findings_total > 1) s += grouped(v.findings_total - 1) + " more:\n";
  for (std::size_t n = 1; n < v.findings.size() && n <= kPlacesTold; ++n) s += one_line(v.findings[n]);
  return s + "compared: " + counts(v) + "\n";
}

std::string to_json(const RunVerdict& v) {
  Json j{{"identical", v.identical()},
         {"wall_s", double(v.wall_ns) * 1e-9},
         {"tolerance", v.tolerance},
         {"largest_difference", v.largest_difference},
         {"log_messages", v.log_messages},
         {"findings_total", v.findings_total},
         {"provenance", v.provenance},
         {"changed_settings", v.changed_settings},
         {"notes", v.notes},
         {"altered", v.altered}};
  if (v.largest_difference > 0) j["largest_difference_field"] = v.largest_difference_field;
  j["not_replayed"] = Json::array();
  for (const NodeVerdict& n : v.not_replayed)
    j["not_replayed"].push_back({{"node", n.name}, {"python", n.python}});
  j["nodes"] = Json::array();
  for (const NodeVerdict& n : v.nodes) j["nodes"].push_back(as_json(n));
  j["damage"] = Json::array();
  for (const DamagedPlace& d : v.damage) {
    j["damage"].push_back({{"file", d.file}, {"offset", d.offset}, {"bytes", d.bytes}, {"reason", d.reason}});
    if (d.step) j["damage"].back()["step"] = *d.step;
  }
  j["ignored"] = Json::array();
  for (const Ignored& i : v.ignored)
    j["ignored"].push_back({{"field", i.field}, {"reason", i.reason}, {"times", i.times}});
  j["findings"] = Json::array();
  for (const Finding& f : v.findings) j["findings"].push_back(as_json(f));
  return j.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace firn::replay
