// The link row: who answers at a port, and the fault when it is not the instrument of the lab file.
#include <algorithm>

#include "config/device_kinds.h"
#include "core/options/number.h"
#include "drivers/gas/alicat.h"
#include "drivers/jet/jet_driver.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/stage/grbl.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

constexpr double kAnswerWithin_s = 2.0;

std::string request_text(const drivers::Request& r) { return std::string(r.text()); }

struct Probe : drivers::LinkProbe {
  std::string_view node;  ///< of port_defaults, or the word of a kind of jet or stage
};
constexpr std::string_view kGrbl = "grbl";
constexpr std::string_view kPointLaser = "laser_point";

std::vector<Probe> probes_of(const Product& product) {
  using namespace drivers;
  std::vector<Probe> all;
  for (const NamedMaker& maker : product.nodes)
    if (maker.probe) all.push_back({maker.probe(), info(maker.id).name});
  all.push_back({grbl::link_probe(), kGrbl});
  for (std::size_t n = 0; n < kJetKindWords.size(); ++n) {
    const JetTraits& jet = traits_of(JetKind(n));
    for (const Request& question : jet.questions())
      all.push_back({{jet.instrument, request_text(question), jet.answers}, kJetKindWords[n]});
  }
  return all;
}

std::string_view kind_of(const Experiment& e, std::string_view node) {
  if (const drivers::JetConfig* jet = jet_of(e, node)) return drivers::kJetKindWords[std::size_t(jet->kind)];
  if (node == "stage" && has_grbl_stage(e)) return kGrbl;
  if (node == "laser_profiler" && has_point_scan(e)) return kPointLaser;
  return node == "valve_b" ? "valve_a" : node;
}

std::string other_instrument(const Probe& p, const std::string& node, const PortAddress& address) {
  const auto is_jet = [](std::string_view kind) {
    return std::ranges::find(drivers::kJetKindWords, kind) != drivers::kJetKindWords.end();
  };
  if (is_jet(p.node) && node.starts_with("jet"))
    return "set " + node + ".kind = \"" + std::string(p.node) + "\"";
  if (p.node == kGrbl && node == "stage") return "set devices.stage.kind = \"grbl\"";
  if (p.node == kPointLaser && node == "laser_profiler") return "set devices.laser_profiler.kind = \"lkg\"";
  return "exchange the addresses in [devices]: " + to_text(address) + " belongs to " +
         (is_jet(p.node) ? "jet" : std::string(p.node));
}

// A class in Python is asked as a print asks it: it alone knows its instrument's language.
BringupFinding class_is_ready(BringupLab& lab, const std::string& node) {
  const std::string& kind = device_kind(lab.e, node);
  if (const std::string why = lab.drive(node, "serial"); !why.empty())
    return {false, why, "identify() and safe() of " + kind + " return",
            "power, cable and address; then what the exception names in its file"};
  return {true, "'" + lab.identities[node] + "' answers " + kind, "identify() and safe() return"};
}

// The lamp burns and is warm, or an exposure will be refused.
BringupFinding lamp_is_ready(RawLine& line) {
  const std::string reply = line.ask_line(drivers::omnicure::frame("GUS"), '\r');
  const auto status =
      whole_number<unsigned>(std::string_view(reply).substr(0, std::max<std::size_t>(reply.size(), 3) - 3));
  if (!drivers::omnicure::is_line(reply) || !status)
    return {false, drivers::shown_line(reply) + " to GUS", "a status", "the manual's GUS"};
  const unsigned bits = *status;
  BringupFinding f{true, "GUS " + std::to_string(bits), "burns, warm, shutter closed, no alarm"};
  f.ok = (bits & 0x12) == 0x12 && (bits & 0x8D) == 0;
  f.mend = (bits & 2) == 0    ? "the lamp does not burn: switch it on at its panel, or lamp.auto_on"
           : (bits & 16) == 0 ? "the lamp is cold: wait until its panel says ready (lamp.warm_up_s)"
           : (bits & 4) != 0  ? "the shutter is open: close it at the panel"
                              : "alarm or fault: look at its panel";
  return f;
}

BringupFinding stage_is_ready(RawLine& line) {
  const std::string reply = line.ask_line("AXISSTATUS(@0)\n");
  const std::string_view text = std::string_view(reply).substr(0, reply.find_last_not_of("\r\n") + 1);
  const std::optional<std::int64_t> bits =
      text.starts_with('%') ? whole_number<std::int64_t>(text.substr(1)) : std::nullopt;
  if (!bits)
    return {false, drivers::shown_line(reply) + " to AXISSTATUS", "a status", "the manual's AXISSTATUS"};
  return {(std::uint32_t(*bits) >> 31) == 0, "AXISSTATUS " + std::to_string(*bits), "bit 31 clear",
          "the emergency stop is pressed: release it, then run this again"};
}

}  // namespace

const drivers::JetConfig* jet_of(const Experiment& e, std::string_view node) {
  return node == "jet" ? &e.jet : node == "jet_b" ? &e.jet_b.drive : nullptr;
}

BringupFinding check_link(BringupLab& lab, const std::string& node) {
  if (is_python_driver(lab.e, node)) return class_is_ready(lab, node);
  const PortAddress address = lab.address(node);
  RawLine line(address);
  if (!line.is_open())
    return {false, line.trouble().empty() ? "the port does not open" : line.trouble(), "an open port",
            "cable, power and address; ./firn doctor LAB looks at each port"};
  std::string all;
  const std::string_view kind = kind_of(lab.e, node);
  const std::vector<Probe> probes = probes_of(lab.product);
  for (const Probe& p : probes) {
    if (p.node != kind) continue;
    const std::string& unit = lab.e.gas.atomizer_unit;
    const std::string question = p.node == "gas" && !unit.empty()
                                     ? request_text(drivers::alicat::poll_request({unit[0], false}, 0))
                                     : p.question;
    const std::string heard = line.ask(
        question, [&](std::string_view s) { return p.answers(s); }, kAnswerWithin_s);
    all += heard;
    if (!p.answers(heard)) continue;
    if (node == "lamp") return lamp_is_ready(line);
    if (kind == "stage") return stage_is_ready(line);
    return {true, std::string(p.instrument) + " answers", "an answer"};
  }
  // Nothing else is sent: a question of another maker's may move, fire or light what truly is there. What
  // came may tell whose port it is.
  for (const Probe& p : probes)
    if (p.node != kind && !all.empty() && p.answers(all))
      return {false, "this is the port of " + std::string(p.instrument), "the port of " + node,
              other_instrument(p, node, address)};
  if (all.empty())
    return {
        false, "no byte comes", "an answer",
        "power, cable, remote mode at its panel; then its speed (baud), address and terminators; and whether "
        "the addresses in [devices] are exchanged: " +
            to_text(address) + " may belong to another instrument"};
  return {false, std::to_string(all.size()) + " bytes that are no answer: " + drivers::shown_line(all),
          "an answer",
          address.kind == PortAddress::Kind::kSerial
              ? "wrong baud or frame: set serial:…?baud=N&frame=8N1 as its panel says, not " +
                    std::to_string(address.baud)
              : "another instrument, or other terminators and dialect than the lab file's"};
}

}  // namespace firn
