// Rows of the robot, the valves, the point laser and the heater. Nothing here moves the arm or opens a valve.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "drivers/heater/thermostat.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "print/bringup/bringup.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

using namespace drivers;

class RobotHand {
 public:
  explicit RobotHand(BringupLab& lab) : line_(lab.line("robot")) { say("HELLO FIRN 1"); }
  /// @returns the answer without its number; "" none
  std::string say(const std::string& words) {
    seq_ = fvp::next_seq(seq_);
    LineWriter out;
    out.text("@").number(seq_).word(words);
    const std::string heard =
        line_->ask(std::string(out.finish(1)), [&](std::string_view s) { return !answer_in(s).empty(); });
    return answer_in(heard);
  }
  RawLine& line() { return *line_; }

 private:
  std::string answer_in(std::string_view heard) const {
    for (std::size_t end; (end = heard.find('\n')) != heard.npos; heard.remove_prefix(end + 1)) {
      const fvp::Message m = fvp::parse(heard.substr(0, end + 1));
      if (m.kind == fvp::Message::Kind::kNumbered && m.seq == seq_) return std::string(m.text);
    }
    return "";
  }
  std::unique_ptr<RawLine> line_;
  std::int64_t seq_ = 0;
};

BringupFinding robot_speed(BringupLab& lab, const std::string&) {
  RobotHand robot(lab);
  constexpr int kLines = 50;
  const std::int64_t begin = monotonic_us();
  int answered = 0;
  for (int n = 0; n < kLines; ++n) answered += robot.say("HB").starts_with("ACK");
  const double each_s = double(monotonic_us() - begin) * 1e-6 / kLines;
  return {answered == kLines && each_s < 0.016,
          number_text(1.0 / each_s) + " lines a second, " + std::to_string(answered) + " of 50 answered",
          "62.5, one a tick of 16 ms",
          "robot.block_lines = 1, and upload only between paths (docs/devices/robot.md)"};
}

BringupFinding robot_numbers(BringupLab& lab, const std::string&) {
  RobotHand robot(lab);
  const std::string id = std::to_string(fvp::kMaxId);
  const std::string begun = robot.say("PATH BEGIN " + id + " N=2 DT=0.016"),
                    dropped = robot.say("PATH DROP " + id);
  return {begun.starts_with("ACK") && dropped.starts_with("ACK"), "'" + begun + "', '" + dropped + "'",
          "ACK, ACK", "V+ reals of this controller hold fewer digits: fvp::kMaxId, kMaxCount"};
}

// The robot's third signal starts the laser's storage.
struct Storage {
  int values = 0;
  double wanted = 0.0;  ///< until the end was told
};
Storage store_while_signal(BringupLab& lab, const std::string& end_by) {
  for (const char* node : {"robot", "laser_point"})
    if (const std::string why = lab.drive(node, "stop"); !why.empty()) throw BringupStop(why);
  const auto laser = lab.line("laser_point");
  const auto say = [&](const std::string& command) { return laser->ask_line(command + "\r", '\r', 4.0); };
  const auto& l = lab.e.laser_point;
  const auto* sampling = std::ranges::find(lkg::kSampling_us, l.sampling_us);
  const int cycle = lkg::cycle_code(int(std::lround(1e6 / l.rate_hz / l.sampling_us)));
  for (const std::string& command :
       {std::string("Q0"), "SW,CA," + std::to_string(sampling - std::begin(lkg::kSampling_us)),
        "SW,CI,1,65536," + std::to_string(cycle), std::string("R0"), std::string("AQ"), std::string("AS")})
    if (const std::string reply = say(command); !reply.starts_with(command.substr(0, 2)))
      throw BringupStop("the laser answers '" + command + "' by '" + reply + "'");
  RobotHand robot(lab);
  if (const std::string up = robot.say("SIG 4"); !up.starts_with("ACK"))
    throw BringupStop("SIG 4: '" + up + "'");
  const std::int64_t begin = monotonic_us();
  laser->wait(0.5);
  robot.say(end_by);
  const double seconds = double(monotonic_us() - begin) * 1e-6;
  laser->wait(1.0);
  robot.say("SIG 0");
  say("AP");
  const std::string stored = say("AN");
  const auto parsed = stored.size() > 4
                          ? lkg::parse_stored(std::string_view(stored).substr(3, stored.size() - 4))
                          : std::nullopt;
  if (!parsed) throw BringupStop("AN is answered '" + stored + "'");
  return {parsed->values, seconds * l.rate_hz};
}

BringupFinding storage_by_signal(BringupLab& lab, const std::string&) {
  const Storage s = store_while_signal(lab, "SIG 0");
  return {s.values > 0.5 * s.wanted && s.values < 1.5 * s.wanted + 10.0, std::to_string(s.values) + " values",
          "about " + number_text(s.wanted),
          s.values == 0
              ? "the robot's signal 3 does not reach the laser's timing input: cable, terminal of T1"
              : "laser_point.rate_hz, or the storage cycle of the laser's program"};
}

BringupFinding signals_fall(BringupLab& lab, const std::string&) {
  const Storage s = store_while_signal(lab, "STOP");
  return {s.values > 0 && s.values < 1.5 * s.wanted + 10.0, std::to_string(s.values) + " values until STOP",
          "about " + number_text(s.wanted),
          "STOP must take the signals down: V+ program, a relay that drops with arm power"};
}

BringupFinding laser_storage(BringupLab& lab, const std::string&) {
  if (const std::string why = lab.drive("laser_point", "stop"); !why.empty()) throw BringupStop(why);
  const auto laser = lab.line("laser_point");
  const auto say = [&](const char* command) {
    return laser->ask_line(std::string(command) + "\r", '\r', 4.0);
  };
  say("AP");
  say("AQ");
  const std::string stored = say("AN"), dump = say("AO,1");
  const bool parses =
      stored.size() > 4 && lkg::parse_stored(std::string_view(stored).substr(3, stored.size() - 4));
  return {parses && dump.starts_with("AO"),
          "'" + stored.substr(0, stored.size() - !stored.empty()) + "', '" +
              dump.substr(0, std::min<std::size_t>(dump.size(), 20)) + "'",
          "AN,<0|1>,<values>[,<values>] and AO…", "lkg::Table, parse_stored, parse_dump"};
}

BringupFinding laser_settings(BringupLab& lab, const std::string&) {
  const auto laser = lab.line("laser_point");
  const auto say = [&](const char* command) {
    return laser->ask_line(std::string(command) + "\r", '\r', 4.0);
  };
  say("R0");
  const std::string enter = say("Q0");
  std::string refused;
  for (const char* command : {"SW,CA,4", "SW,OC,1,0,2", "SW,HB,1,1", "SW,CI,1,65536,4"})
    if (const std::string reply = say(command); reply != std::string(command).substr(0, 5) + "\r")
      refused += std::string(command) + " -> " + reply.substr(0, 12) + "; ";
  const std::string held = say("SR,HB,1"), leave = say("R0");
  const bool ok = enter == "Q0\r" && leave == "R0\r" && refused.empty();
  return {ok && held == "SR,HB,1,1\r", refused.empty() ? "all taken; " + held.substr(0, 12) : refused,
          "echoed without arguments, read back", "lkg::Table: numbers of SW,CA, SW,OC, SW,HB, SW,CI"};
}

BringupFinding laser_times(BringupLab& lab, const std::string&) {
  const auto laser = lab.line("laser_point");
  const auto time_of = [&](const char* command) {
    laser->ask_line(std::string(command) + "\r", '\r', 4.0);
    return laser->last_answer_s();
  };
  time_of("R0");
  const double enter_s = time_of("Q0"), leave_s = time_of("R0"), select_s = time_of("PW,0");
  const double slowest_s = std::max({enter_s, leave_s, select_s});
  return {slowest_s < 3.0,
          "Q0 " + number_text(enter_s) + " s, R0 " + number_text(leave_s) + " s, PW " +
              number_text(select_s) + " s",
          "3 s", "kMode_us of laser_point.cpp, timeouts of LkgDialect"};
}

class ValveHand {
 public:
  ValveHand(BringupLab& lab, const std::string& node) : line_(lab.line(node)) { say(fvb::Type::kHello, {}); }
  std::string say(fvb::Type type, std::span<const std::byte> payload) {
    std::vector<std::byte> bytes;
    fvb::encode(type, seq_ = fvb::next_seq(seq_), payload, bytes);
    return send(bytes);
  }
  std::string send(const std::vector<std::byte>& bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string heard = line_->ask(
        text, [](std::string_view s) { return fvb::find(bytes_of(s)).kind == fvb::Found::Kind::kFrame; });
    const auto reply = fvb::parse_reply(fvb::find(bytes_of(heard)));
    return !reply                           ? "no answer"
           : reply->type == fvb::Type::kNak ? "NAK " + std::to_string(reply->refusal)
                                            : std::string(fvb::name(reply->type));
  }
  std::uint8_t next() { return seq_ = fvb::next_seq(seq_); }
  RawLine& line() { return *line_; }

 private:
  std::unique_ptr<RawLine> line_;
  std::uint8_t seq_ = 0;
};

BringupFinding valve_refuses(BringupLab& lab, const std::string& node) {
  ValveHand valve(lab, node);
  const std::byte wait[4] = {};
  const std::string arm = valve.say(fvb::Type::kArm, wait);  // nothing is loaded
  std::vector<std::byte> begin, data;
  fvb::encode(valve.next(), fvb::Begin{1, std::uint8_t(node == "valve_b" ? 2 : 1), 2, 2000, 1250}, begin);
  const std::string begun = valve.send(begin);
  const std::uint16_t backwards[] = {10, 5};
  fvb::encode_data(valve.next(), 0, backwards, data);
  const std::string order = valve.send(data);
  valve.say(fvb::Type::kAbort, {});
  valve.line().send("\xA5\x5A\x02");  // half a frame
  valve.line().wait(0.2);
  const std::string after = valve.say(fvb::Type::kHello, {});
  return {arm == "NAK 20" && order == "NAK 22" && begun != "no answer" && after != "no answer",
          "ARM without a list: " + arm + "; times backwards: " + order + "; after half a frame: " + after,
          "NAK 20, NAK 22, an answer", "the firmware does not keep to docs/devices/valve.md"};
}

BringupFinding valve_caps(BringupLab& lab, const std::string& node) {
  ValveHand valve(lab, node);
  const auto begin = [&](std::uint16_t pulse_us) {
    std::vector<std::byte> bytes;
    fvb::encode(valve.next(), fvb::Begin{1, std::uint8_t(node == "valve_b" ? 2 : 1), 2, 2000, pulse_us},
                bytes);
    return valve.send(bytes);
  };
  const std::string shortest = begin(100), close = begin(1250);
  std::vector<std::byte> data;
  const std::uint16_t dense[] = {10, 10};
  fvb::encode_data(valve.next(), 0, dense, data);
  const std::string gap = valve.send(data);
  valve.say(fvb::Type::kAbort, {});
  return {shortest == "NAK 21" && gap == "NAK 22", "pulse of 100 us: " + shortest + "; no gap: " + gap,
          "NAK 21, NAK 22", "the firmware's cap against coil heat (interlock 12): valve_*.guard_us"};
}

/// Else a platen's heater, on channel 1.
bool has_ice_heaters(const Experiment& e, std::string_view) {
  return e.heater.platen_degC <= kHeaterOff_degC;
}

BringupFinding temperatures(BringupLab& lab, const std::string& node) {
  const auto line = lab.line(node);
  const Request asked = thermostat::read_request(0);
  const thermostat::ThermostatDialect dialect;
  const std::string heard =
      line->ask(asked.text(), [&](std::string_view s) { return is_whole_reply(dialect, asked, s); });
  const auto text = checked_text(heard, 0);
  const auto reading = text ? thermostat::parse_reading(*text) : std::nullopt;
  if (!reading)
    return {false, "'" + heard + "'", "three temperatures", "the read-out box's lines: thermostat.h"};
  std::string measured;
  bool ok = true;
  const std::size_t channels = has_ice_heaters(lab.e, node) ? reading->celsius.size() : 1;
  for (const double t : std::span(reading->celsius).first(channels)) {
    measured += std::isnan(t) ? "open " : number_text(t) + " degC ";
    ok = ok && t > -40.0 && t < 60.0;
  }
  return {ok, measured, std::to_string(channels) + " of -40 to 60 degC",
          measured.find("open") != measured.npos ? "an open thermocouple: its plug, its wire, its channel"
                                                 : "type of the thermocouple set in the box"};
}

BringupFinding heater_refuses(BringupLab& lab, const std::string& node) {
  const auto line = lab.line(node);
  LineWriter high;
  high.text("S,1,99999");  // beyond any box's limit
  std::string damaged(thermostat::read_request(0).text());
  damaged[0] = 'U';
  const std::string too_high = line->ask_line(high.finish(0)), broken = line->ask_line(damaged);
  const auto code = [](const std::string& said) { return std::string(checked_text(said, 0).value_or(said)); };
  return {code(too_high) == "E,3" && code(broken) == "E,1",
          "999.99 degC: '" + code(too_high) + "'; a damaged line: '" + code(broken) + "'", "E,3, E,1",
          "the box's firmware does not keep to docs/devices/heater.md"};
}

constexpr BringupRow kRows[] = {
    {28, "robot", "lines a second with their CRC", "robot.block_lines", &robot_speed},
    {34, "robot", "numbers up to 9,999,999 survive", "fvp::kMaxId", &robot_numbers},
    {29, "robot", "DURATION 0.016 ALWAYS is kept on every point", "ice.max_time_slip_s"},
    {31, "robot", "time from the signal to the motion: firn calibrate", "ice.*_latency_s"},
    {32, "robot", "J3: up is positive on the wire", "fvp::Counts"},
    {33, "robot", "BRAKE stops within the clearance; MOVEZ after CLEAR", "robot.raise_on_stop_mm"},
    {35, "robot", "watchdog of 1.0 s in a path: signals off, BRAKE", "the V+ program"},
    {36, "valve_a", "refuses what it must, and forgets half a frame", "the firmware", &valve_refuses},
    {38, "valve_a", "caps pulse and gap", "the firmware's cap", &valve_caps},
    {37, "valve_a", "a pull-down keeps it closed through a reset", "wiring"},
    {39, "valve_a", "its clock against the robot's over 131 s", "drivers/valve/valve.cpp"},
    {40, "laser_point", "bodies of AN and AO", "lkg::parse_stored, parse_dump", &laser_storage},
    {41, "laser_point", "numbers of SW,CA, SW,OC, SW,HB, SW,CI", "lkg::Table", &laser_settings},
    {44, "laser_point", "times of R0, Q0, PW", "kMode_us", &laser_times},
    {42, "laser_point", "storage begins with the robot's signal", "laser_point.latency_s",
     &storage_by_signal},
    {30, "robot", "STOP takes the signals down", "the V+ program", &signals_fall},
    {43, "laser_point", "settings in a program outlive power", "LaserPoint::push_settings"},
    {45, "heater", "believable temperatures: three, or a platen's", "thermostat.h", &temperatures},
    {46, "heater", "the window heater alone keeps the valves above freezing", "heater.low_degC", nullptr,
     &has_ice_heaters},
    {55, "valve_a", "spike and hold outputs are low before, through and after a reset, the 24 V supply off",
     "firmware/valve"},
    {56, "valve_a",
     "spike of 300 us, then hold; low at once by the enable line, 2 s after the cable is pulled",
     "firmware/valve"},
    {57, "heater", "refuses a damaged line and a set point beyond its limit", "firmware/heater",
     &heater_refuses},
    {58, "heater", "relays fall in a reset and with a thermocouple unplugged, and come again",
     "firmware/heater"},
};

}  // namespace

std::span<const BringupRow> ice_rows() { return kRows; }

}  // namespace firn
