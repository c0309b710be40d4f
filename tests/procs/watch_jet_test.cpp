// The scheduler's watch of its jet: gate, purge, lead of the pulses, crashes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "firn/fault_t.hpp"
#include "plant/inkjet/strobe_picture.h"
#include "procs/scheduler/jet_check.h"
#include "tests/procs/fake_lab.h"

namespace firn::test {
namespace {

constexpr std::int32_t kAllKnown = 127;

droplet_sweep_t good_sweep(double v_m_s = 2.0) {
  droplet_sweep_t m{};
  m.frames = m.with_droplet = m.used = 12;
  m.known = kAllKnown;
  m.um_per_px = 2.0;
  m.middle_us = 120.0;
  m.velocity_mm_s = 1e3 * v_m_s;
  m.velocity_std_mm_s = 5.0;
  m.diameter_mm = 0.06;
  return m;
}

Experiment watched() {
  Experiment e = small();
  e.camera.use = OnOff::kOn;
  e.watch.gate = OnOff::kOn;
  return e;
}

// "move", "jet", "pictures", "disarm", "pass" … of all commands.
std::string words(const FakeLab& lab) {
  std::string text;
  for (const auto& s : lab.sent) {
    if (s.channel == "STAGE_COMMAND") {
      const auto verb = StageVerb(lab.decode<stage_command_t>(s).verb);
      text += verb == StageVerb::kPass ? "pass " : verb == StageVerb::kMove ? "move " : "";
    }
    if (s.channel == "JET_COMMAND") {
      const auto verb = JetVerb(lab.decode<jet_command_t>(s).verb);
      text += verb == JetVerb::kJet ? "jet " : verb == JetVerb::kArm ? "arm " : "disarm ";
    }
    if (s.channel == "CAMERA_COMMAND") text += "pictures ";
  }
  return text;
}

std::vector<std::string> faults(const FakeLab& lab, std::int32_t code) {
  std::vector<std::string> texts;
  for (const fault_t& f : lab.all(channels::fault(NodeId::kScheduler)))
    if (f.code == code) texts.push_back(f.text);
  return texts;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("A lab without a camera sends it nothing") {
  FakeLab lab(1);
  lab.print(0.0);
  CHECK(lab.all(channels::kCameraCommand).empty());
}

TEST_CASE("The jet is watched beside the part before the first droplet, and not again") {
  FakeLab lab(1, watched());
  lab.seen_by_camera = [](const camera_command_t&) { return good_sweep(); };
  lab.print(0.0);
  CHECK(words(lab).starts_with("move jet pictures disarm arm pass disarm "));
  CHECK(count(words(lab), "pictures ") == 1);
  const auto c = lab.all(channels::kCameraCommand).at(0);
  CHECK(c.frames == watched().watch.frames);
  CHECK(c.delay_us == watched().watch.first_us);
  CHECK(c.step_us == watched().watch.step_us);
}

TEST_CASE(
    "For the droplet estimator the jet is watched before the first scan, and not again before layer 1") {
  Experiment e = watched();
  e.estimator.droplets = "camera";
  FakeLab lab(1, e);
  lab.seen_by_camera = [](const camera_command_t&) { return good_sweep(); };
  lab.print(0.0);
  CHECK(words(lab).starts_with("move jet pictures disarm arm pass disarm "));
  CHECK(count(words(lab), "pictures ") == 1);
  const auto first = [&](const std::string& channel) {
    return std::ranges::find(lab.sent, channel, [](const auto& s) { return std::string(s.channel); }) -
           lab.sent.begin();
  };
  CHECK(first("CAMERA_COMMAND") < first("PROFILER_COMMAND"));
}

TEST_CASE("The jet is watched again after every k layers") {
  Experiment e = watched();
  e.watch.every_layers = 2;
  FakeLab lab(1, e);
  lab.layers = 5;
  lab.seen_by_camera = [](const camera_command_t&) { return good_sweep(); };
  lab.print(0.0);
  CHECK(count(words(lab), "pictures ") == 3);
}

TEST_CASE("A jet outside its band is purged once and may print then") {
  FakeLab lab(1, watched());
  lab.seen_by_camera = [n = 0](const camera_command_t&) mutable {
    return n++ == 0 ? droplet_sweep_t{} : good_sweep();
  };
  lab.print(0.0);
  CHECK(words(lab).starts_with("move jet pictures disarm jet disarm jet pictures disarm arm pass "));
  REQUIRE(faults(lab, 11).size() == 1);
  CHECK_THAT(faults(lab, 11)[0], Catch::Contains("the jet before layer 1: no droplet in 12 pictures") &&
                                     Catch::Contains("purging once"));
}

TEST_CASE("A jet that stays outside its band stops the print before a droplet, by name") {
  FakeLab lab(1, watched());
  lab.seen_by_camera = [](const camera_command_t&) { return good_sweep(0.5); };
  lab.begin(0);
  for (int n = 0; n < 500 && lab.all(channels::kRunEnd).empty(); ++n)
    if (!lab.serve(0.0)) lab.wake();
  REQUIRE(lab.all(channels::kRunEnd).size() == 1);
  CHECK(RunOutcome(lab.last(channels::kRunEnd).outcome) == RunOutcome::kStoppedSafely);
  CHECK_THAT(lab.last(channels::kRunEnd).reason,
             Catch::Contains("its velocity is 0.5 +- 0.005 m/s, watch.velocity_least_m_s = 1"));
  CHECK(lab.fired.empty());
}

TEST_CASE("Each limit of the band is named with value, deviation and key") {
  droplet::WatchOptions o;
  const auto judged = [&](auto&& change) {
    droplet_sweep_t m = good_sweep();
    change(m);
    return jet_out_of_band(m, o).text;
  };
  CHECK(judged([](auto&) {}).empty());
  CHECK_THAT(judged([](auto& m) { m.velocity_mm_s = 7000; }), Catch::Contains("watch.velocity_most_m_s = 6"));
  CHECK_THAT(judged([](auto& m) { m.angle_rad = -0.1; }),
             Catch::Contains("its angle is -5.73") && Catch::Contains("watch.angle_most_deg = 3"));
  CHECK_THAT(judged([](auto& m) { m.satellites = 1; }),
             Catch::Contains(", watch.satellites_most = 0") && !Catch::Contains(" ,"));
  CHECK_THAT(judged([](auto& m) { m.um_per_px = 0; }), Catch::Contains("watch.nozzle_um"));
  CHECK_THAT(judged([](auto& m) { m.known = 0; }), Catch::Contains("its velocity is not known"));
}

TEST_CASE("The lead is the stage's way while the droplet falls, to 3 um through 1 mm at 1 to 4 m/s") {
  const double speed_m_s = GENERATE(1.0, 1.5, 2.5, 4.0), diameter_um = GENERATE(40.0, 100.0);
  double low = 0.0, high = 1e5;
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (low + high);
    (plant::fly(speed_m_s, diameter_um, middle).um < 1000.0 ? low : high) = middle;
  }
  droplet_sweep_t m = good_sweep(plant::fly(speed_m_s, diameter_um, 120.0).speed_m_s);
  m.diameter_mm = 1e-3 * diameter_um;
  const double stage_mm_s = 150.0;
  CHECK(std::abs(lead_of(m, stage_mm_s, 1.0) - stage_mm_s * 1e-6 * high) < 0.003);
}

TEST_CASE("Passes carry the lead with placement on, and none without it or without a velocity") {
  Experiment e = watched();
  e.watch.gate = OnOff::kOff;
  e.watch.placement = OnOff::kOn;
  const bool known = GENERATE(true, false);
  FakeLab lab(1, e);
  lab.seen_by_camera = [&](const camera_command_t&) { return known ? good_sweep() : droplet_sweep_t{}; };
  lab.print(0.0);
  const double wanted =
      known ? lead_of(good_sweep(), e.process.pass_speed_mm_s, e.process.nozzle_gap_mm) : 0.0;
  CHECK((wanted > 0.0) == known);
  for (const stage_command_t& c : lab.all(channels::kStageCommand))
    CHECK(c.lead_mm == (StageVerb(c.verb) == StageVerb::kPass ? wanted : 0.0));
  CHECK(faults(lab, 11).size() == (known ? 0u : 1u));
}

TEST_CASE("However often a watched print crashes, no droplet is doubled and the stage rests while it jets") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Experiment e = watched();
    e.watch.every_layers = 1;
    FakeLab lab(seed, e);
    lab.seen_by_camera = [n = 0](const camera_command_t&) mutable {
      return n++ % 3 == 0 ? droplet_sweep_t{} : good_sweep();
    };
    lab.print(0.15);
    CHECK_FALSE(lab.moved_while_jetting);
    for (const auto& [pass, cells] : lab.fired)
      for (const auto& [cell, times] : cells) CHECK(times == 1);
  }
}

}  // namespace firn::test
