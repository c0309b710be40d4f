// The link row: who answers at a port, and the fault when it is not the instrument of the lab file.
#include <algorithm>
#include <charconv>

#include "drivers/camera/picture_line.h"
#include "drivers/gas/alicat.h"
#include "drivers/heater/thermostat.h"
#include "drivers/jet/jet_driver.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_profiler/ljv.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

constexpr double kAnswerWithin_s = 2.0, kOthersWithin_s = 0.5;

std::string request_text(const drivers::Request& r) { return std::string(r.text()); }

bool ensemble_line(std::string_view s) {
  return s.size() >= 2 && s.size() < 200 && std::string_view("%!#$").find(s[0]) != s.npos && s.back() == '\n';
}

// A line of the OmniCure: CR at its end, two hex digits before it that are the CRC of the rest.
bool omnicure_line(std::string_view s) {
  if (s.size() < 4 || s.back() != '\r') return false;
  const std::string_view text = s.substr(0, s.size() - 3);
  return drivers::omnicure::frame(text) == s;
}

// An answer to another line may come before.
bool omnicure_answers(std::string_view s) {
  if (s.size() < 2) return false;
  return omnicure_line(s.substr(s.find_last_of('\r', s.size() - 2) + 1));
}

bool whole_reply(const drivers::Dialect& dialect, const drivers::Request& asked, std::string_view s) {
  return !s.empty() && dialect.frame(bytes_of(s), &asked).kind == drivers::Frame::Kind::kReply;
}

std::string hello_robot() {
  drivers::LineWriter line;
  line.text("@").number(1).word("HELLO FIRN 1");
  return std::string(line.finish(1));
}

// Questions that change nothing, and who answers them.
struct Probe {
  std::string_view node;  ///< of port_defaults, or the word of a kind of jet
  std::string_view instrument;
  std::string question;
  bool (*answered)(std::string_view heard);
};

const std::vector<Probe>& probes() {
  using namespace drivers;
  static const std::vector<Probe> all = [] {
    std::vector<Probe> p;
    p.push_back({"stage", "an Aerotech stage", "NONE\n", &ensemble_line});
    p.push_back({"lamp", "an OmniCure lamp", omnicure::frame("CONN"), &omnicure_answers});
    p.push_back({"laser_profiler", "a Keyence LJ-V profiler", request_text(ljv::get_newest_profile(false)),
                 [](std::string_view s) {
                   return whole_reply(ljv::LjvDialect(), ljv::get_newest_profile(false), s);
                 }});
    p.push_back({"laser_point", "a Keyence LK-G laser", "PR\r", [](std::string_view s) {
                   return s.ends_with('\r') && (s.starts_with("PR,") || s.starts_with("ER,"));
                 }});
    p.push_back({"heater", "a heater's read-out box", request_text(thermostat::read_request(0)),
                 [](std::string_view s) {
                   return whole_reply(thermostat::ThermostatDialect(), thermostat::read_request(0), s);
                 }});
    p.push_back({"robot", "a robot with FVP/1", hello_robot(), [](std::string_view s) {
                   return s.find("\r\n") != s.npos &&
                          drivers::fvp::parse(s.substr(0, s.find("\r\n") + 2)).kind !=
                              drivers::fvp::Message::Kind::kBad;
                 }});
    std::vector<std::byte> hello;
    fvb::encode(fvb::Type::kHello, 1, {}, hello);
    p.push_back({"valve_a", "a valve with FVB/1",
                 std::string(reinterpret_cast<const char*>(hello.data()), hello.size()),
                 [](std::string_view s) { return fvb::find(bytes_of(s)).kind == fvb::Found::Kind::kFrame; }});
    p.push_back({"camera", "a camera behind Firn's picture lines", request_text(picture_line::identify()),
                 [](std::string_view s) {
                   return s.ends_with('\n') && (s.starts_with("OK ID") || s.starts_with("NO "));
                 }});
    p.push_back({"gas", "an Alicat flow controller", request_text(alicat::poll_request({}, 0)),
                 [](std::string_view s) {
                   return s.ends_with('\r') && alicat::parse_reading(s.substr(0, s.size() - 1)).has_value();
                 }});
    for (std::size_t n = kJetKindWords.size(); n-- > 0;) {  // last JetDrive: its monitor takes single letters
      const JetTraits& jet = traits_of(JetKind(n));
      for (const Request& question : jet.questions())
        p.push_back({kJetKindWords[n], jet.instrument, request_text(question), jet.answers});
    }
    return p;
  }();
  return all;
}

std::string_view kind_of(const Experiment& e, std::string_view node) {
  if (const drivers::JetConfig* jet = jet_of(e, node)) return drivers::kJetKindWords[std::size_t(jet->kind)];
  return node == "valve_b" ? "valve_a" : node;
}

bool is_kind_of_jet(std::string_view kind) {
  return std::ranges::find(drivers::kJetKindWords, kind) != drivers::kJetKindWords.end();
}

std::string other_instrument(const Probe& p, const std::string& node, std::string_view kind,
                             const PortAddress& address) {
  const bool is_jet = is_kind_of_jet(p.node);
  if (is_jet && is_kind_of_jet(kind)) return "set " + node + ".kind = \"" + std::string(p.node) + "\"";
  const std::string_view owner = is_jet ? "jet" : p.node;
  return "exchange the addresses in [devices]: " + to_text(address) + " belongs to " + std::string(owner);
}

std::string printable(std::string_view bytes) {
  std::string text;
  for (const char c : bytes.substr(0, 24)) text += c >= 0x20 && c < 0x7f ? c : '.';
  return text;
}

// The lamp burns and is warm, or an exposure will be refused.
BringupFinding lamp_is_ready(RawLine& line) {
  const std::string reply = line.ask_line(drivers::omnicure::frame("GUS"), '\r');
  unsigned bits = 0;
  std::from_chars(reply.data(), reply.data() + (reply.size() < 3 ? 0 : reply.size() - 3), bits);
  if (!omnicure_line(reply))
    return {false, "'" + printable(reply) + "' to GUS", "a status", "the manual's GUS"};
  BringupFinding f{true, "GUS " + std::to_string(bits), "burns, warm, shutter closed, no alarm"};
  f.ok = (bits & 0x12) == 0x12 && (bits & 0x8D) == 0;
  f.mend = (bits & 2) == 0    ? "the lamp does not burn: switch it on at its panel, or lamp.auto_on"
           : (bits & 16) == 0 ? "the lamp is cold: wait until its panel says ready (lamp.warm_up_s)"
           : (bits & 4) != 0  ? "the shutter is open: close it at the panel"
                              : "alarm or fault: look at its panel";
  return f;
}

BringupFinding stage_is_ready(RawLine& line) {
  long bits = 0;
  const std::string reply = line.ask_line("AXISSTATUS(@0)\n");
  if (reply.size() > 1) bits = std::strtol(reply.c_str() + 1, nullptr, 10);
  return {(std::uint32_t(bits) >> 31) == 0, "AXISSTATUS " + std::to_string(bits), "bit 31 clear",
          "the emergency stop is pressed: release it, then run this again"};
}

}  // namespace

const drivers::JetConfig* jet_of(const Experiment& e, std::string_view node) {
  return node == "jet" ? &e.jet : node == "jet_b" ? &e.jet_b.drive : nullptr;
}

BringupFinding check_link(BringupLab& lab, const std::string& node) {
  const PortAddress address = lab.address(node);
  RawLine line(address);
  if (!line.is_open())
    return {false, line.trouble().empty() ? "the port does not open" : line.trouble(), "an open port",
            "cable, power and address; ./firn doctor LAB looks at each port"};
  std::string all;
  const auto answers = [&](const Probe& p, double within_s, const std::string& before = "") {
    const std::string& unit = lab.e.gas.atomizer_unit;
    const std::string question = p.node == "gas" && !unit.empty()
                                     ? request_text(drivers::alicat::poll_request({unit[0], false}, 0))
                                     : p.question;
    const std::string heard = line.ask(
        before + question, [&](std::string_view s) { return p.answered(s); }, within_s);
    all += heard;
    return p.answered(heard);
  };
  const std::string_view kind = kind_of(lab.e, node);
  for (const Probe& p : probes()) {
    if (p.node != kind || !answers(p, kAnswerWithin_s)) continue;
    if (node == "lamp") return lamp_is_ready(line);
    if (node == "stage") return stage_is_ready(line);
    return {true, std::string(p.instrument) + " answers", "an answer"};
  }
  // Another instrument has taken the questions before as the beginning of a line; a lamp passes over a line
  // whose CRC is wrong.
  for (const Probe& p : probes())
    if (p.node != kind && answers(p, kOthersWithin_s, p.node == "lamp" ? "\r" : ""))
      return {false, "this is the port of " + std::string(p.instrument), "the port of " + node,
              other_instrument(p, node, kind, address)};
  if (all.empty())
    return {false, "no byte comes", "an answer",
            "power, cable, remote mode at its panel; then its speed (baud), address and terminators"};
  return {false, std::to_string(all.size()) + " bytes that are no answer: '" + printable(all) + "'",
          "an answer",
          address.kind == PortAddress::Kind::kSerial
              ? "wrong baud or frame: set serial:…?baud=N&frame=8N1 as its panel says, not " +
                    std::to_string(address.baud)
              : "another instrument, or other terminators and dialect than the lab file's"};
}

}  // namespace firn
