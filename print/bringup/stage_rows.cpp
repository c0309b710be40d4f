// Rows of the stage. Whatever moves stays within the lab's limits, at most 5 mm and 10 mm/s, and is aborted
// when it is not over in time. Pulses go out on Y, to the profiler; the jet, on X, is made safe before.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/options/number.h"
#include "drivers/stage/ensemble.h"
#include "print/bringup/bringup.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

namespace ens = drivers::ensemble;

constexpr double kSpeed_mm_s = 10.0, kMove_mm = 4.0;

// A stage past its driver; its axes are stopped when this ends.
class StageHand {
 public:
  StageHand(BringupLab& lab, const std::string& node) : lab_(lab), line_(lab.line(node)) {}
  ~StageHand() {
    if (moving_) line_->ask_line("ABORT @0 @1 @2\n");
  }

  std::string say(const std::string& command) { return line_->ask_line(command + "\n"); }
  void must(const std::string& command) {
    if (const std::string reply = say(command); reply != "%\n")
      throw BringupStop("'" + command + "' is answered '" + reply.substr(0, 20) + "'");
  }
  double value(const std::string& question) {
    const std::string reply = say(question);
    std::optional<double> v;
    if (reply.size() > 2 && reply[0] == '%')
      v = whole_number<double>(std::string_view(reply).substr(1, reply.size() - 2));
    if (!v) throw BringupStop("'" + question + "' is answered '" + reply.substr(0, 20) + "'");
    return *v;
  }
  RawLine& line() { return *line_; }

  void prepare() {
    for (const char* command : {"WAIT MODE NOWAIT", "ABS", "ENABLE @0", "ENABLE @1", "ENABLE @2"})
      must(command);
    must("RAMP RATE " + number_text(lab_.e.stage.acceleration_mm_s2));
    if (on(lab_.e.stage.linear_ramps)) must("SCURVE 0");
  }
  void begin(int axis, double to_mm) {
    const auto& s = lab_.e.stage;
    const double low[] = {s.x_min_mm, s.y_min_mm, s.z_min_mm}, high[] = {s.x_max_mm, s.y_max_mm, s.z_max_mm};
    if (!(to_mm >= low[axis] && to_mm <= high[axis]))
      throw BringupStop("axis " + std::to_string(axis) + " would leave the limits of the lab file at " +
                        number_text(to_mm) + " mm");
    moving_ = true;
    must("LINEAR @" + std::to_string(axis) + " " + number_text(to_mm) + " F" + number_text(kSpeed_mm_s));
    begun_us_ = monotonic_us();
  }
  /// @returns the time since begin() [s]
  double settle(int axis) {
    while (value("PLANESTATUS(0)") != 0.0) {
      line_->wait(0.005);
      if (monotonic_us() - begun_us_ > 10'000'000 || lab_.interrupted())
        throw BringupStop("the move is not over after " +
                          number_text(double(monotonic_us() - begun_us_) * 1e-6) + " s");
      if (const double bits = value("AXISFAULT(@" + std::to_string(axis) + ")"); bits != 0.0)
        throw BringupStop("the axis has a fault: " + ens::fault_names(std::uint32_t(std::int64_t(bits))));
    }
    moving_ = false;
    return double(monotonic_us() - begun_us_) * 1e-6;
  }
  double move(int axis, double to_mm) {
    begin(axis, to_mm);
    return settle(axis);
  }
  double position(int axis) { return value("PFBKPROG(@" + std::to_string(axis) + ")"); }
  /// A place kMove_mm from here, within the limits.
  double place_beside(int axis, double by_mm = kMove_mm) {
    const auto& s = lab_.e.stage;
    const double high[] = {s.x_max_mm, s.y_max_mm, s.z_max_mm}, at = position(axis);
    return at + by_mm <= high[axis] ? at + by_mm : at - by_mm;
  }
  void arm_y(const std::string& distance) {
    for (const char* command : {"PSOCONTROL @1 RESET", "PSOOUTPUT @1 CONTROL 1", "PSOOUTPUT @1 PULSE",
                                "PSOPULSE @1 TIME 50,25", "PSOTRACK @1 INPUT 0"})
      must(command);
    must("PSODISTANCE @1 " + distance);
  }

 private:
  BringupLab& lab_;
  std::unique_ptr<RawLine> line_;
  bool moving_ = false;
  std::int64_t begun_us_ = 0;
};

void jet_is_safe(BringupLab& lab) {
  for (const char* jet : {"jet", "jet_b"})
    if (lab.has(jet))
      if (const std::string why = lab.drive(jet, "stop"); !why.empty())
        throw BringupStop(std::string("not before ") + jet + " is safe: " + why);
}

BringupFinding reply_characters(BringupLab& lab, const std::string& node) {
  StageHand stage(lab, node);
  const std::string unknown = stage.say("NONE"), status = stage.say("AXISSTATUS(@0)");
  return {unknown == "!\n" && status.size() > 2 && status[0] == '%' && status.back() == '\n',
          "'" + unknown.substr(0, 1) + "', '" +
              status.substr(0, std::min<std::size_t>(status.find('\n'), 12)) + "'",
          "'!', then % and a number, line feed",
          "parameters 177 to 180 of the controller, and \"Always Send EOS\""};
}

BringupFinding global_integers(BringupLab& lab, const std::string& node) {
  StageHand stage(lab, node);
  const double held = stage.value("GETPARM(@0, " + std::to_string(int(ens::kGlobalIntegers)) + ")");
  const double wanted = lab.e.stage.first_iglobal + 1.0;
  return {held >= wanted, number_text(held) + " global integers",
          "at least " + number_text(wanted) + " (stage.first_iglobal)",
          "raise GlobalIntegers in the controller, or lower stage.first_iglobal"};
}

BringupFinding limits_and_counts(BringupLab& lab, const std::string& node) {
  StageHand stage(lab, node);
  const auto& s = lab.e.stage;
  const double low[] = {s.x_min_mm, s.y_min_mm, s.z_min_mm}, high[] = {s.x_max_mm, s.y_max_mm, s.z_max_mm};
  std::string measured;
  for (int a = 0; a < 3; ++a) {
    const auto parameter = [&](ens::Parameter p) {
      return stage.value("GETPARM(@" + std::to_string(a) + ", " + std::to_string(int(p)) + ")");
    };
    const double counts = parameter(ens::kCountsPerUnit), from = parameter(ens::kSoftwareLimitLow),
                 to = parameter(ens::kSoftwareLimitHigh), setup = parameter(ens::kSoftwareLimitSetup);
    const std::string axis(1, "XYZ"[a]);
    measured += (a > 0 ? "; " : "") + axis + " " + number_text(counts) + " counts, [" + number_text(from) +
                ", " + number_text(to) + "] mm";
    if (std::abs(counts - s.counts_per_mm) > 1e-6 * s.counts_per_mm)
      return {
          false, axis + ": CountsPerUnit " + number_text(counts),
          "stage.counts_per_mm = " + number_text(s.counts_per_mm),
          "wrong counts per unit: correct stage.counts_per_mm or the controller's CountsPerUnit; else every "
          "move is " +
              number_text(s.counts_per_mm / counts) + " times too long"};
    if (setup == 0.0)
      return {false, axis + ": SoftwareLimitSetup 0", "soft limits on",
              "switch the controller's soft limits on"};
    if (from > low[a] + 1e-4 || to < high[a] - 1e-4)
      return {
          false, axis + ": soft limits [" + number_text(from) + ", " + number_text(to) + "] mm",
          "around [" + number_text(low[a]) + ", " + number_text(high[a]) + "] mm",
          "narrow stage." + std::string(1, "xyz"[a]) + "_min_mm, _max_mm, or widen the controller's limits"};
  }
  return {true, measured, "the lab file's"};
}

BringupFinding burst(BringupLab& lab, const std::string& node) {
  StageHand stage(lab, node);
  const auto lines = [](std::string_view s) { return std::count(s.begin(), s.end(), '\n'); };
  const std::string heard = stage.line().ask("AXISSTATUS(@0)\nAXISSTATUS(@1)\nPLANESTATUS(0)\n",
                                             [&](std::string_view s) { return lines(s) >= 3; });
  return {lines(heard) == 3, std::to_string(lines(heard)) + " answers to three lines in one chunk", "3",
          "the stop burst is not safe on this firmware: tell us, with --record"};
}

BringupFinding homing(BringupLab& lab, const std::string& node) {
  const std::int64_t begin = monotonic_us();
  const std::string why = lab.drive(node, "home", {}, lab.e.stage.home_timeout_s * 3);
  return {why.empty(),
          why.empty() ? "home after " + number_text(double(monotonic_us() - begin) * 1e-6) + " s" : why,
          "home within stage.home_timeout_s an axis",
          "stage.homing = \"command\" where HomeAsync.bcx is not on the controller"};
}

BringupFinding status_bits(BringupLab& lab, const std::string& node) {
  StageHand stage(lab, node);
  stage.prepare();
  const auto bits = [&] { return std::uint32_t(std::int64_t(stage.value("AXISSTATUS(@0)"))); };
  const std::uint32_t rest = bits();
  stage.begin(0, stage.place_beside(0));
  const std::uint32_t moving = bits();
  stage.settle(0);
  const std::uint32_t after = bits();
  const bool ok = (rest & ens::kEnabled) && (rest & ens::kHomed) && !(rest & ens::kMoving) &&
                  (moving & ens::kMoving) && !(after & ens::kMoving);
  char text[80];
  std::snprintf(text, sizeof text, "at rest %08x, moving %08x, after %08x", rest, moving, after);
  return {ok, text, "bits 0, 1 at rest, 3 while it moves", "ensemble.h: the bits of this firmware"};
}

BringupFinding trapezoid(BringupLab& lab, const std::string& node) {
  StageHand stage(lab, node);
  stage.prepare();
  const double s = stage.move(0, stage.place_beside(0));
  const double planned = kMove_mm / kSpeed_mm_s + kSpeed_mm_s / lab.e.stage.acceleration_mm_s2;
  return {s > 0.9 * planned && s < 1.1 * planned + 0.3,
          number_text(s) + " s for " + number_text(kMove_mm) + " mm", number_text(planned) + " s",
          "the ramps are no trapezoid of stage.acceleration_mm_s2: SCURVE, RAMP MODE"};
}

BringupFinding pulse_counter(BringupLab& lab, const std::string& node) {
  if (lab.e.stage.pulse_count == drivers::PulseCounter::kNone)
    return {true, "stage.pulse_count = \"none\"", "a counter, or none"};
  jet_is_safe(lab);
  StageHand stage(lab, node);
  stage.prepare();
  const double to_mm = stage.place_beside(1, 3.2);
  stage.arm_y("FIXED 0.5 UNITS");
  stage.must("PSOCONTROL @1 ARM");
  stage.move(1, to_mm);
  const std::string question =
      std::string(drivers::kPulseCounterWords[std::size_t(lab.e.stage.pulse_count)]) + "(@1)";
  const double armed = stage.value(question);
  stage.must("PSOCONTROL @1 OFF");
  const double off = stage.value(question);
  stage.must("ABORT @1");
  const double aborted = stage.value(question);
  return {armed == 6.0 && off == 6.0 && aborted == 6.0,
          number_text(armed) + ", after OFF " + number_text(off) + ", after ABORT " + number_text(aborted),
          "6 pulses in 3.2 mm",
          "stage.pulse_count = \"PSOSTATUS\" or \"none\": a row that was broken off is then in doubt"};
}

// Rows 3 and 4: the array is copied at PSOARRAY, and after its last entry comes no pulse.
BringupFinding pulse_array(BringupLab& lab, const std::string& node) {
  if (lab.e.stage.pulse_count == drivers::PulseCounter::kNone)
    return {false, "there is no counter", "4 pulses", "look at the profiler's trigger count, or at a scope"};
  jet_is_safe(lab);
  StageHand stage(lab, node);
  stage.prepare();
  const double to_mm = stage.place_beside(1, 4.0);
  const int first = lab.e.stage.first_iglobal;
  const auto set = [&](int n, double mm) {
    stage.must("IGLOBAL(" + std::to_string(first + n) +
               ")=" + number_text(std::round(mm * lab.e.stage.counts_per_mm)));
  };
  for (int n = 0; n < 4; ++n) set(n, 0.5);
  stage.arm_y("FIXED 1 UNITS");
  stage.must("PSOARRAY @1," + std::to_string(first) + ",4");
  stage.must("PSODISTANCE @1 ARRAY");
  stage.must("PSOCONTROL @1 ARM");
  for (int n = 0; n < 4; ++n) set(n, 3.0);
  stage.move(1, to_mm);
  const double pulses =
      stage.value(std::string(drivers::kPulseCounterWords[std::size_t(lab.e.stage.pulse_count)]) + "(@1)");
  stage.must("PSOCONTROL @1 OFF");
  return {pulses == 4.0, number_text(pulses) + " pulses in 4 mm", "4, the array's as it was at PSOARRAY",
          pulses < 4.0 ? "the array is read while it moves: increments must stay until the run is over"
                       : "pulses come after the array's last entry: shorten the run-out"};
}

constexpr BringupRow kStageRows[] = {
    {8, "stage", "reply characters and terminators", "controller parameters", &reply_characters},
    {9, "stage", "several lines in one chunk are all answered", "send_stop_burst", &burst},
    {12, "stage", "counts per unit and soft limits", "[stage]", &limits_and_counts},
    {5, "stage", "number of global integers", "stage.first_iglobal", &global_integers},
    {11, "stage", "which limit switches are wired, and their polarity", "controller parameters"},
    {7, "stage", "homes, and says so", "stage.homing", &homing},
    {10, "stage", "status bits", "ensemble.h", &status_bits},
    {6, "stage", "moves as a trapezoid", "stage.acceleration_mm_s2", &trapezoid},
    {1, "stage", "counter of pulses, also after OFF and ABORT", "stage.pulse_count", &pulse_counter},
    {3, "stage", "PSOARRAY copies the increments at once", "Stage::push_arming", &pulse_array},
    {4, "stage", "no pulse after the last entry", "Stage::count_run", &pulse_array},
};

}  // namespace

std::span<const BringupRow> stage_rows() { return kStageRows; }

}  // namespace firn
