// Rows of the jet, the profiler and the lamp.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "config/device_kinds.h"
#include "core/options/number.h"
#include "drivers/jet/jet_driver.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_profiler/ljv.h"
#include "drivers/stage/ensemble.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

std::string hex(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    char one[4];
    std::snprintf(one, sizeof one, "%02X ", unsigned(static_cast<unsigned char>(c)));
    text += one;
  }
  return text.empty() ? "nothing" : text;
}

// The jet's driver has brought it into its remote mode.
std::string jet_answer(BringupLab& lab, const std::string& node, std::string_view frame, std::size_t size) {
  if (const std::string why = lab.drive(node, "stop"); !why.empty()) throw BringupStop(why);
  return lab.line(node)->ask(frame, [size](std::string_view s) { return s.size() >= size; });
}

BringupFinding version_reply(BringupLab& lab, const std::string& node) {
  const std::string r = jet_answer(lab, node, "S\x02\xF0\xF2", 5);
  const bool ok = r.size() == 5 && r[0] == 0x06 && static_cast<unsigned char>(r[1]) == 0xF0;
  return {ok, hex(r), "06 F0 status version sum",
          "[devices.jet.dialect] command_at, status_at, version_size"};
}

BringupFinding reply_sum(BringupLab& lab, const std::string& node) {
  const std::string r = jet_answer(lab, node, std::string_view("S\x02\x02\x04", 4), 4);
  const bool ok = r.size() == 4 && r[0] == 0x06 && r[1] == 0x02 && char(r[1] + r[2]) == r[3];
  return {ok, hex(r), "06 02 status, and their sum", "JetDriveDialect::frame: which bytes the sum covers"};
}

bool is_jetdrive(const Experiment& e, std::string_view node) {
  const drivers::JetConfig* jet = jet_of(e, node);
  return jet && jet->kind == drivers::JetKind::kJetdrive;
}

bool is_armed_by_words(const Experiment& e, std::string_view node) {
  const drivers::JetConfig* jet = jet_of(e, node);
  return jet && drivers::traits_of(jet->kind).trigger_by_words;
}

// A jet is safe when its driver has set it up: it has read every setting back that can be read.
BringupFinding set_up_and_armable(BringupLab& lab, const std::string& node) {
  if (const std::string why = lab.drive(node, "stop"); !why.empty()) throw BringupStop(why);
  const std::string why = drivers::unarmable(*jet_of(lab.e, node));
  return {why.empty(), why.empty() ? "settings held, a trigger command" : "settings held, no trigger command",
          "settings held, and the command of its trigger input", node + ": " + why};
}

// Asks the profiler for its newest profile.
drivers::ljv::RawProfile newest(RawLine& line) {
  using namespace drivers;
  const Request asked = ljv::get_newest_profile(false);
  const ljv::LjvDialect dialect;
  const std::string reply =
      line.ask(asked.text(), [&](std::string_view s) { return is_whole_reply(dialect, asked, s); });
  ljv::RawProfile raw;
  if (reply.empty() || !ljv::parse_profile(bytes_of(reply), raw))
    throw BringupStop("42h is answered by " + std::to_string(reply.size()) + " bytes that are no profile");
  return raw;
}

// One pulse on Y and the profile that it gives, for rows 2, 20 and 21.
const BringupLab::OnePulse& one_pulse(BringupLab& lab) {
  if (lab.one_pulse) return *lab.one_pulse;
  constexpr double kPulse_mm = 2.0, kMove_mm = 3.0;
  for (const char* jet : {"jet", "jet_b"})
    if (lab.has(jet))
      if (const std::string why = lab.drive(jet, "stop"); !why.empty())
        throw BringupStop(std::string("not before ") + jet + " is safe: " + why);
  if (const std::string why = lab.drive("laser_profiler", "stop"); !why.empty()) throw BringupStop(why);
  BringupLab::OnePulse p;
  const auto stage = lab.line("stage");
  const auto profiler = lab.line("laser_profiler");
  const auto say = [&](const std::string& command) {
    const std::string reply = stage->ask_line(command + "\n");
    if (reply.empty() || reply[0] != '%') throw BringupStop("'" + command + "' is answered '" + reply + "'");
    return reply;
  };
  const auto value = [&](const std::string& question) {
    const std::string reply = say(question);
    const auto v = whole_number<double>(std::string_view(reply).substr(1, reply.size() - 2));
    if (!v) throw BringupStop("'" + question + "' is answered '" + reply + "'");
    return *v;
  };
  for (const char* command :
       {"WAIT MODE NOWAIT", "ABS", "ENABLE @1", "PSOCONTROL @1 RESET", "PSOOUTPUT @1 CONTROL 1",
        "PSOOUTPUT @1 PULSE", "PSOPULSE @1 TIME 50,25", "PSOTRACK @1 INPUT 0"})
    say(command);
  const double from_mm = value("PFBKPROG(@1)"),
               sign = from_mm + kMove_mm <= lab.e.stage.y_max_mm ? 1.0 : -1.0;
  const auto raw = newest(*profiler);
  const std::uint32_t before = raw.points > 0 ? raw.trigger_count : 0;
  p.expected_mm = from_mm + sign * kPulse_mm;
  say("PSODISTANCE @1 FIXED " + number_text(kPulse_mm) + " UNITS");
  say("PSOCONTROL @1 ARM");
  say("LINEAR @1 " + number_text(from_mm + sign * kMove_mm) + " F10");
  for (int n = 0; n < 1000 && value("PLANESTATUS(0)") != 0.0; ++n) {
    stage->wait(0.005);
    if (n == 999 || lab.interrupted()) {
      stage->ask_line("ABORT @1\n");
      throw BringupStop("the move is not over in 5 s");
    }
  }
  say("PSOCONTROL @1 OFF");
  profiler->wait(0.05);
  const auto after = newest(*profiler);
  p.triggers = after.points > 0 ? std::int32_t(after.trigger_count - before) : 0;
  p.encoder_mm = after.encoder_count / lab.e.stage.counts_per_mm;
  lab.one_pulse = p;
  return *lab.one_pulse;
}

BringupFinding first_pulse(BringupLab& lab, const std::string&) {
  const auto& p = one_pulse(lab);
  const bool ok = p.triggers == 1 && std::abs(p.encoder_mm - p.expected_mm) < 0.05;
  return {
      ok,
      p.triggers == 1 ? "at " + number_text(p.encoder_mm) + " mm" : std::to_string(p.triggers) + " pulses",
      number_text(p.expected_mm) + " mm: one distance after the place of ARM",
      "see rows 20 and 21 first; then plan_raster: a shift of every row"};
}

BringupFinding trigger_and_encoder(BringupLab& lab, const std::string&) {
  constexpr double kNear_mm = 0.5;  // row 21 is stricter
  const auto& p = one_pulse(lab);
  if (p.triggers == 0)
    return {
        false, "no profile after a pulse of the stage", "one",
        "trigger mode of the head's program, and the cable from the stage's PSO output to its trigger input"};
  const std::string measured =
      std::to_string(p.triggers) + " profile, encoder at " + number_text(p.encoder_mm) + " mm";
  const std::string limit = "1, " + number_text(p.expected_mm) + " mm";
  if (std::abs(p.encoder_mm + p.expected_mm) < kNear_mm && std::abs(p.expected_mm) > kNear_mm)
    return {false, measured, limit, "the encoder counts backwards: its direction in the head's program"};
  if (std::abs(p.encoder_mm - p.expected_mm) > kNear_mm)
    return {false, measured, limit,
            "axes swapped, or the profiler's encoder input is on another axis than Y, or of another scale"};
  return {p.triggers == 1, measured, limit, "more than one trigger a pulse: trigger input's filter"};
}

BringupFinding encoder_at_trigger(BringupLab& lab, const std::string&) {
  const auto& p = one_pulse(lab);
  return {p.triggers > 0 && std::abs(p.encoder_mm - p.expected_mm) < 0.05, number_text(p.encoder_mm) + " mm",
          number_text(p.expected_mm) + " mm +- 0.05",
          "counts per mm of the encoder input, or its count is read later than the trigger"};
}

BringupFinding profile_shape(BringupLab& lab, const std::string& node) {
  one_pulse(lab);  // so that there is a profile
  const auto line = lab.line(node);
  const auto raw = newest(*line);
  if (raw.points == 0) return {false, "no profile yet", "one", "row 20"};
  std::string measured = std::to_string(raw.points) + " points every " + number_text(raw.dx_mm) + " mm";
  const auto& l = lab.e.laser_profiler;
  if (raw.points != l.points || (l.dx_mm > 0.0 && std::abs(raw.dx_mm - l.dx_mm) > 1e-6))
    return {false, measured,
            std::to_string(l.points) + " points" +
                (l.dx_mm > 0.0 ? " every " + number_text(l.dx_mm) + " mm" : ""),
            "laser_profiler.points, dx_mm, or the head's program"};
  const auto valid = std::ranges::count_if(raw.z_mm, [](float z) { return std::isfinite(z); });
  measured += ", " + number_text(100.0 * double(valid) / double(raw.points)) + " % with a value";
  return {valid * 2 > raw.points, measured, "half of them with a value",
          "the line is out of the head's range, or its exposure is wrong: its panel"};
}

// A person lays a gauge block under the line: sign, mirror and unit of its reading.
BringupFinding gauge(BringupLab& lab, const std::string& node) {
  constexpr double kGauge_mm = 0.5, kTolerance = 0.1;
  one_pulse(lab);
  const auto before = newest(*lab.line(node));
  const auto laid =
      lab.ask(47, "lay a gauge block of " + number_text(kGauge_mm) +
                      " mm under the line, at its end of smaller part x, shorter than half of it; done?");
  if (!laid) return {false, "", "", "needs a person"};
  lab.one_pulse.reset();
  one_pulse(lab);
  const auto after = newest(*lab.line(node));
  if (before.points != after.points || after.points == 0) return {false, "no profile", "one", "row 20"};
  const auto& l = lab.e.laser_profiler;
  double rise_mm = 0.0, at = 0.0;
  int n = 0;
  for (int i = 0; i < after.points; ++i) {
    const double d = double(after.z_mm[std::size_t(i)]) - double(before.z_mm[std::size_t(i)]);
    if (!(std::abs(d) > 0.3 * kGauge_mm)) continue;
    rise_mm += d;
    at += i;
    ++n;
  }
  if (n < 5)
    return {false, "the reading does not change", number_text(kGauge_mm) + " mm",
            "the block is not under the line"};
  rise_mm /= n;
  at /= n;
  const double sign = l.z_sign == drivers::ZSign::kUp ? 1.0 : -1.0;
  const bool left = (at < 0.5 * after.points) == !on(l.mirror_x);
  const std::string measured = number_text(std::round(sign * rise_mm * 100.0) / 100.0) +
                               " mm, at the end of " + (left ? "smaller" : "greater") + " x";
  const std::string limit = "+" + number_text(kGauge_mm) + " mm, at the end of smaller x";
  if (std::abs(std::abs(rise_mm) - kGauge_mm) > kTolerance * kGauge_mm + 0.01)
    return {false, measured, limit, "wrong unit or scale of z: the head's program, ljv.h"};
  if (sign * rise_mm < 0.0)
    return {false, measured, limit,
            std::string("the profiler is upside down: laser_profiler.z_sign = \"") +
                (sign > 0 ? "down" : "up") + "\""};
  return {left, measured, limit,
          std::string("the profiler is mirrored: laser_profiler.mirror_x = \"") +
              (on(l.mirror_x) ? "off" : "on") + "\""};
}

BringupFinding profile_in_time(BringupLab& lab, const std::string& node) {
  const auto line = lab.line(node);
  double slowest_s = 0.0;
  for (int n = 0; n < 10; ++n) {
    newest(*line);
    slowest_s = std::max(slowest_s, line->last_answer_s());
  }
  return {slowest_s < 0.1, number_text(slowest_s * 1e3) + " ms for the slowest of ten", "100 ms",
          "the head waits for a trigger before it answers: sampling mode of its program; or a slow network"};
}

std::string lamp_says(RawLine& line, std::string_view command) {
  const std::string reply = line.ask_line(drivers::omnicure::frame(command), '\r');
  if (reply.size() < 4 ||
      drivers::omnicure::frame(std::string_view(reply).substr(0, reply.size() - 3)) != reply)
    return "";
  return reply.substr(0, reply.size() - 3);
}

BringupFinding lamp_back_to_back(BringupLab& lab, const std::string& node) {
  const auto line = lab.line(node);
  lamp_says(*line, "CONN");
  int good = 0;
  for (int n = 0; n < 20; ++n) good += !lamp_says(*line, "GUS").empty() && lamp_says(*line, "GUS") != "Err";
  return {good == 20, std::to_string(good) + " of 20 answered", "20",
          "it needs a pause between commands: OmnicureDialect timeouts"};
}

BringupFinding lamp_time(BringupLab& lab, const std::string& node) {
  const auto line = lab.line(node);
  lamp_says(*line, "CONN");
  const std::string set = lamp_says(*line, "STM5"), got = lamp_says(*line, "GTM");
  return {set == "Received" && got == "5", "STM5: '" + set + "', GTM: '" + got + "'", "'Received', '5'",
          "tenths are no unit of this lamp: the driver falls back to its own timer by itself"};
}

BringupFinding lamp_run(BringupLab& lab, const std::string& node) {
  const auto clear =
      lab.ask(23, "the shutter opens for 0.2 s at an iris of 1 %: is the light where nobody sees it?");
  if (!clear) return {false, "", "", "needs a person"};
  if (!*clear) return {false, "not carried out", "", "clear the place, then run this row again"};
  const std::string why = lab.drive(node, "expose", {0.2, 1.0});
  return {why.empty(), why.empty() ? "opened and closed by its status bits" : why, "open, then closed",
          why.find("open") != why.npos || why.find("shutter") != why.npos
              ? "the shutter is stuck, or lamp.status_bits are others on this lamp"
              : "switch it on and wait until it is warm: lamp.warm_up_s; STM, RUN unknown: instrument_timer"};
}

// These rows give the stage one pulse past its driver.
bool pulses_of_an_ensemble(const Experiment& e, std::string_view) {
  return !has_grbl_stage(e) && !is_python_driver(e, "stage");
}

constexpr BringupRow kInkjetRows[] = {
    {13, "jet", "GETVERSION answers 06, command, status, version, sum", "[devices.jet.dialect]",
     &version_reply, &is_jetdrive},
    {14, "jet", "the sum of a reply is that of command and status", "JetDriveDialect::frame", &reply_sum,
     &is_jetdrive},
    {51, "jet", "holds what it is told, and has a trigger", "jet.trigger_on, trigger_off",
     &set_up_and_armable, &is_armed_by_words},
    {15, "jet", "SOURCE 1 does not fire by itself, SOURCE 0 holds triggers off: ink on paper",
     "drivers/jet/jet.cpp"},
    {16, "jet", "trigger polarity and pulse length, 25 us of 50 us: a scope", "StageOptions::pulse_*_us"},
    {17, "jet", "droplets stay stable up to jet.max_rate_hz: strobe", "jet.max_rate_hz"},
    {18, "jet", "the head bears the waveform's voltages", "jet.dwell_v, jet.echo_v"},
    {22, "laser_profiler", "42h answers at once", "get_newest_profile", &profile_in_time},
    {20, "laser_profiler", "external trigger, encoder input on Y", "the head's program", &trigger_and_encoder,
     &pulses_of_an_ensemble},
    {21, "laser_profiler", "encoder count is that at the trigger", "procs/laser_profiler/node.cpp",
     &encoder_at_trigger, &pulses_of_an_ensemble},
    {2, "laser_profiler", "the first pulse comes one distance after ARM", "plan_raster", &first_pulse,
     &pulses_of_an_ensemble},
    {19, "laser_profiler", "points of a profile, their distance", "laser_profiler.points", &profile_shape},
    {47, "laser_profiler", "sign, side and unit of z by a gauge block", "laser_profiler.z_sign, mirror_x",
     &gauge},
    {25, "lamp", "answers to commands back to back", "OmnicureDialect", &lamp_back_to_back},
    {24, "lamp", "GTM reads back what STM set, in tenths", "omnicure::Table", &lamp_time},
    {23, "lamp", "RUN opens, and closes by itself", "omnicure::Table", &lamp_run},
    {26, "lamp", "a relay closes it when its cable is pulled with the shutter open", "a relay"},
};

}  // namespace

std::span<const BringupRow> inkjet_rows() { return kInkjetRows; }

}  // namespace firn
