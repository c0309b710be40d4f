#include "tests/drivers/wire_exchange.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/grid/firing_order.h"
#include "drivers/camera/camera.h"
#include "drivers/gas/gas.h"
#include "plant/world/aerosol_lab.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/ice_rig.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/wire_rig.h"
#include "tests/drivers/world_rig.h"

namespace firn::drivers::test {
namespace {

using plant::FaultKind;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kFaultShare = 0.25;  // of the commands
constexpr double kKernelGivesUp_s =
    3.0;  // TCP_USER_TIMEOUT of runtime/port_wire.cpp; tests/runtime/half_open_test
constexpr double kEnds_s = 300.0, kTaken_s = 60.0;

/// One instrument of a rig: commands with disturbances, and their reckoning.
template <class Rig>
class Session {
 public:
  template <class... Args>
  Session(RealWire::Kind kind, std::string target, std::uint64_t seed, Args&&... args)
      : rig(kind, std::forward<Args>(args)...), kind_(kind), seed_(seed) {
    figures.instrument = std::move(target);
    rig.start();
  }

  /// Commands until it is taken. Only the target's line is disturbed.
  Result command(const std::string& port, const PortRig::Act& act) {
    const std::int64_t asked_us = rig.now_us;
    for (;;) {
      const std::size_t before = rig.template all<Result>(port).size();
      const std::int64_t begin_us = rig.now_us;
      rig.act(port, act);
      const bool taken = rig.template all<Result>(port).size() == before;  // a refusal comes at once
      if (taken && port == figures.instrument && chance() < kFaultShare) disturb();
      if (!rig.run([&] { return rig.template all<Result>(port).size() > before; }, kEnds_s)) {
        wrong(port + " gives no answer");
        return {};
      }
      const Result r = rig.template all<Result>(port)[before];
      told = std::move(rig.events[port]);
      rig.events[port].clear();
      if (r.outcome == Outcome::kRefused) {
        if (double(rig.now_us - asked_us) * 1e-6 > kTaken_s) {
          wrong(port + " takes no command: " + r.text);
          return r;
        }
        rig.run_for(0.05);
        continue;
      }
      ++figures.commands;
      if (recovers_since_us_ > 0 && begin_us >= recovers_since_us_) {
        const double took_s = double(begin_us - recovers_since_us_) * 1e-6;
        if (took_s > figures.slowest_s) figures.slowest_after = disturbed_by_;
        figures.slowest_s = std::max(figures.slowest_s, took_s);
        recovers_since_us_ = 0;
      }
      return r;
    }
  }

  void wrong(const std::string& what) {
    if (figures.wrong++ == 0) figures.first_wrong = what;
  }
  void judge(bool truth, const std::string& what, const Result& r) {
    if (!truth) wrong(what + ": " + describe(r));
  }
  std::int64_t random(std::int64_t below) { return std::int64_t(next(seed_) % std::uint64_t(below)); }
  double chance() { return double(random(1000)) * 1e-3; }
  ExchangeFigures done() {
    figures.exchanges = rig.exchanges(figures.instrument);
    return figures;
  }
  bool enough(std::int64_t exchanges) const {
    return rig.exchanges(figures.instrument) >= exchanges || figures.wrong > 20;
  }

  WireRig<Rig> rig;
  ExchangeFigures figures;
  std::vector<DriverEvent> told;  ///< with the last result

 private:
  void inject(FaultKind kind, std::int64_t count, std::int64_t delay_us = 0) {
    disturbed_by_ = plant::fault_name(kind);
    rig.world.inject({figures.instrument, kind, count, delay_us}, rig.now_us);
  }

  void disturb() {
    ++figures.faults;
    rig.run_for(0.3 * chance());
    const double lasts_s = 0.05 + 2.0 * chance();
    switch (random(10)) {
      case 0:
        inject(FaultKind::kDropReply, 1 + random(2));
        break;
      case 1:
        inject(FaultKind::kDelayReply, 1, 400'000 + random(2'500'000));
        break;
      case 2:
        // Between two bytes; a picture has 4096.
        inject(FaultKind::kSplitReply, 1 + random(3),
               figures.instrument == "camera" ? 100 : 1000 + random(20'000));
        break;
      case 3:
        inject(FaultKind::kFlipBit, random(64));
        break;
      case 4:
        inject(FaultKind::kEcho, 1);
        break;
      case 5:
        inject(FaultKind::kStray, 1);
        break;
      case 6:
        inject(FaultKind::kClose, 1);
        break;
      case 7:
        if (kind_ == RealWire::Kind::kTcp) {
          inject(FaultKind::kHalfOpen, 1);
          rig.run_for(kKernelGivesUp_s);
          rig.pull_out(figures.instrument);
          rig.plug_in(figures.instrument);
          break;
        }
        [[fallthrough]];
      case 8:
        inject(FaultKind::kHang, 1);
        rig.run_for(lasts_s);
        inject(FaultKind::kResume, 1);
        disturbed_by_ = "hang";
        break;
      default:
        disturbed_by_ = "unplugged";
        rig.pull_out(figures.instrument);
        rig.run_for(lasts_s);
        rig.plug_in(figures.instrument);
    }
    recovers_since_us_ = rig.now_us;
  }

  RealWire::Kind kind_;
  std::uint64_t seed_;
  std::int64_t recovers_since_us_ = 0;
  std::string disturbed_by_;
};

struct CameraRig : PortRig {
  explicit CameraRig(const plant::WorldConfig& config) : PortRig(config), camera(CameraOptions{}) {
    add("camera", camera);
  }
  void start() { connect_all(); }
  Camera camera;
};

struct GasRig : PortRig {
  explicit GasRig(const plant::WorldConfig& config) : PortRig(config), gas(GasOptions{}) { add("gas", gas); }
  void start() { connect_all(); }
  Gas gas;
};

struct PlatenRig : PortRig {
  explicit PlatenRig(const plant::WorldConfig& config) : PortRig(config), platen(options()) {
    add("heater", platen);
  }
  void start() { connect_all(); }
  static HeaterOptions options() {
    HeaterOptions o;
    o.platen_degC = 60.0;
    o.high_degC = 100.0;
    return o;
  }
  Heater platen;
};

using Gases = Session<GasRig>;
using Platen = Session<PlatenRig>;
using Inkjet = Session<WorldRig>;
using Watch = Session<CameraRig>;
using Ice = Session<IceRig>;

plant::WorldConfig inkjet_world() { return WorldRig::small_world(6, 3); }

void run_stage(Inkjet& s) {
  WireRig<WorldRig>& rig = s.rig;
  rig.written.clear();
  if (s.chance() < 0.5) {
    const double x = s.random(80), y = s.random(80);
    const Result r =
        s.command("stage", [&](std::int64_t t, Effects& fx) { rig.stage.move_to(x, y, kNaN, 0.0, t, fx); });
    if (rig.sent("stage", "LINEAR") > 1) ++s.figures.repeats;
    if (r.outcome == Outcome::kDone)
      s.judge(std::abs(rig.stage.position_mm(0) - x) < 0.01 && std::abs(rig.stage.position_mm(1) - y) < 0.01,
              "a move that is done ends elsewhere", r);
    return;
  }
  const GridSpec grid = rig.world.config().grid;
  DropletPattern p(grid);
  for (auto& c : p.cells) c = std::uint8_t(s.random(2));
  const auto order = firing_order(p, 0);
  auto& shots = rig.record.history.shots;
  shots.clear();
  const Result r =
      s.command("stage", [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(p, 0, 1.0, 0.0, t, fx); });
  const auto put_out = std::int64_t(shots.size());
  if (put_out > std::int64_t(order.size())) ++s.figures.repeats;
  for (std::size_t n = 0; n < shots.size() && n < order.size(); ++n) {
    const double x = grid.x_mm(int(order[n]) % grid.nx), y = grid.y_mm(int(order[n]) / grid.nx);
    s.judge(std::abs(shots[n].x_mm - x) < 5e-4 && std::abs(shots[n].y_mm - y) < 5e-4, "a pulse elsewhere", r);
  }
  if (order.empty()) return;
  s.judge(r.counted <= put_out && put_out <= std::max(r.counted, r.unknown_to), "pulses", r);
  if (r.unknown_from == r.unknown_to) s.judge(r.counted == put_out, "pulses", r);
  if (r.outcome == Outcome::kDone) s.judge(put_out == std::int64_t(order.size()), "done", r);
}

std::int64_t notes(const WireRig<WorldRig>& rig, plant::DeviceEvent event) {
  const auto& all = rig.record.history.devices;
  return std::count_if(all.begin(), all.end(), [&](const auto& d) { return d.event == event; });
}

void run_jet(Inkjet& s) {
  WireRig<WorldRig>& rig = s.rig;
  rig.record.history.devices.clear();
  const Result armed = s.command("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(6, t, fx); });
  if (notes(rig, plant::DeviceEvent::kJetArmed) > 1) ++s.figures.repeats;
  if (armed.outcome == Outcome::kReady)
    s.judge(notes(rig, plant::DeviceEvent::kJetArmed) == 1, "armed and not ready", armed);
  else
    s.judge(rig.jet.state() != DeviceState::kArmed, "armed, and the answer denies it", armed);
  const Result r = s.command("jet", [&](std::int64_t t, Effects& fx) { rig.jet.disarm(t, fx); });
  if (notes(rig, plant::DeviceEvent::kJetArmed) > 1) ++s.figures.repeats;
  s.judge(notes(rig, plant::DeviceEvent::kJetArmed) == notes(rig, plant::DeviceEvent::kJetDisarmed),
          "it is still armed", r);
}

void run_lamp(Inkjet& s) {
  WireRig<WorldRig>& rig = s.rig;
  rig.record.history.lamp.clear();
  const Result r = s.command("lamp", [&](std::int64_t t, Effects& fx) { rig.lamp.expose(0.2, 100, t, fx); });
  std::int64_t opened = 0, closed = 0;
  double dose_s = 0.0;
  for (const auto& e : rig.record.history.lamp) {
    ++(e.event == plant::LampEvent::kOpened ? opened : closed);
    dose_s += e.dose_s;
  }
  if (opened > 1) ++s.figures.repeats;
  if (r.outcome == Outcome::kDone) s.judge(opened == 1 && std::abs(dose_s - 0.2) < 0.35, "dose", r);
  if (r.outcome == Outcome::kNone) s.judge(opened == 0, "it was exposed", r);
  if (r.outcome == Outcome::kDone || r.outcome == Outcome::kNone) s.judge(opened == closed, "it is open", r);
}

void run_profiler(Inkjet& s) {
  WireRig<WorldRig>& rig = s.rig;
  const GridSpec grid = rig.world.config().grid;
  const Result armed =
      s.command("laser_profiler", [&](std::int64_t t, Effects& fx) { rig.profiler.arm(grid.ny, t, fx); });
  if (armed.outcome != Outcome::kReady) return;
  rig.act("stage", [&](std::int64_t t, Effects& fx) {
    rig.stage.scan(1.0, grid.y_mm(0), 1.0, grid.pitch_y_mm, grid.ny, 15.0, t, fx);
  });
  rig.run([&] { return !rig.stage.busy(); }, 60.0);
  const auto rows = rig.template all<ProfileRow>("laser_profiler");
  const Result r = s.command("laser_profiler", [&](std::int64_t t, Effects& fx) { rig.profiler.end(t, fx); });
  for (const ProfileRow& row : rows)
    s.judge(row.row < grid.ny && std::abs(row.encoder_count / 10000.0 - grid.y_mm(row.row)) < 0.001,
            "a row of another place", r);
  if (r.outcome == Outcome::kDone) s.judge(r.counted <= grid.ny, "rows", r);
}

constexpr int kPicture_px = 64;

plant::WorldConfig watched_world() {
  plant::WorldConfig c = inkjet_world();
  c.strobe.width_px = c.strobe.height_px = kPicture_px;
  return c;
}

void run_camera(Watch& s) {
  constexpr std::int32_t kPictures = 3;
  const Sweep wanted{kPictures, double(s.random(1000)), double(s.random(50))};
  const Result r =
      s.command("camera", [&](std::int64_t t, Effects& fx) { s.rig.camera.sweep(wanted, t, fx); });
  std::int32_t n = 0;
  for (const DriverEvent& e : s.told)
    if (const auto* shot = event_cast<CameraShot>(e)) {
      s.judge(shot->index == n && shot->sweep.delay_us == wanted.delay_us &&
                  shot->picture.pixels.size() == std::size_t(kPicture_px * kPicture_px),
              "a picture that was not asked for", r);
      ++n;
    }
  if (n > kPictures) ++s.figures.repeats;
  if (r.outcome == Outcome::kDone) s.judge(n == kPictures && r.counted == kPictures, "pictures", r);
}

plant::WorldConfig aerosol_world() {
  plant::WorldConfig c = inkjet_world();
  c.kind = &plant::kAerosolWorld;
  c.own = plant::AerosolWorldConfig{};
  return c;
}

void run_gas(Gases& s) {
  const double atomizer = double(s.random(25)), sheath = 20.0 + double(s.random(60));
  const Result r =
      s.command("gas", [&](std::int64_t t, Effects& fx) { s.rig.gas.set(atomizer, sheath, t, fx); });
  const auto in_force = [&] { return s.rig.world.truth().gas_set_sccm; };
  if (r.outcome == Outcome::kDone)
    return s.judge(in_force() == std::array{atomizer, sheath}, "set points", r);
  s.judge(s.rig.run([&] { return s.rig.gas.safe(); }, kTaken_s) && in_force()[kAtomizer] == 0.0,
          "atomizer gas goes on", r);
}

void run_platen(Platen& s) {
  const double set = 30.0 + double(s.random(50));
  const Result r = s.command("heater", [&](std::int64_t t, Effects& fx) {
    s.rig.platen.set({set, kHeaterOff_degC, kHeaterOff_degC}, t, fx);
  });
  if (r.outcome == Outcome::kDone) s.judge(s.rig.world.truth().platen_set_degC == set, "set point", r);
}

std::vector<double> sweep(int k) {
  std::vector<double> q;
  for (std::size_t i = 0; i < 60; ++i) {
    const double u = double(i) / 59.0, w = u * u * (3 - 2 * u) * 0.1;
    q.insert(q.end(), {-0.9 + 0.01 * k + 0.15 * w, 1.6 - 0.1 * w, 24.0, -0.7 - 0.01 * k - 0.05 * w});
  }
  return q;
}

/// The arm stands and may be told to move, after whatever stopped it.
bool arm_ready(Ice& s) {
  for (int n = 0; n < 4; ++n)
    if (s.command("robot", [&](std::int64_t t, Effects& fx) { s.rig.robot.home(t, fx); }).outcome ==
        Outcome::kDone)
      return true;
  s.wrong("the arm does not get home");
  return false;
}

/// A path with twenty pulses; the line of robot or valve is disturbed. @param path numbers ascend
void run_path(Ice& s, std::int64_t path) {
  WireRig<IceRig>& rig = s.rig;
  std::vector<std::int32_t> ticks;
  for (int k = 0; k < 20; ++k) ticks.push_back(k * 8);
  rig.act("robot", [&](std::int64_t t, Effects& fx) {
    rig.robot.add_path(path, 0.016, 4, sweep(int(path % 7)), t, fx);
  });
  rig.act("valve_a", [&](std::int64_t t, Effects& fx) {
    rig.valve_a.add_list({path, 0}, 0.002, 0.00125, ticks, t, fx);
  });
  const auto fired = [&] { return rig.world.ice()->ice_truth().pulses[0]; };
  const std::int64_t before = fired();
  const auto valve = [&](auto f) {
    return s.command("valve_a", [&](std::int64_t t, Effects& fx) { f(t, fx); });
  };
  for (int n = 0; n < 5 && !rig.valve_a.holds({path, 0}); ++n) {  // a lost link loses the list
    valve([&](std::int64_t t, Effects& fx) { rig.valve_a.load({path, 0}, t, fx); });
    rig.run_for(1.0);
  }
  if (!rig.valve_a.holds({path, 0})) return s.wrong("valve_a does not load");
  const Result armed = valve([&](std::int64_t t, Effects& fx) { rig.valve_a.arm({path, 0}, t, fx); });
  if (armed.outcome != Outcome::kReady) {
    s.judge(fired() == before, "it fired", armed);
    return;
  }
  const Result ran = s.command("robot", [&](std::int64_t t, Effects& fx) {
    rig.robot.run({path, 0, 0}, kSignalValveA, t, fx);
  });
  if (ran.outcome == Outcome::kDone)
    s.judge(std::abs(ran.counted - ran.expected) <= 20'000, "the time of a path", ran);
  const Result r = valve([&](std::int64_t t, Effects& fx) { rig.valve_a.disarm(t, fx); });
  const std::int64_t pulses = fired() - before;
  if (pulses > 20) ++s.figures.repeats;
  if (ran.outcome == Outcome::kNone) s.judge(pulses == 0, "a path that has not begun fired", ran);
  if (r.outcome == Outcome::kUnknown)
    s.judge(r.unknown_from <= pulses && pulses <= r.unknown_to, "pulses", r);
  else
    s.judge(r.counted == pulses, "pulses", r);
  if (ran.outcome != Outcome::kDone) arm_ready(s);
}

void run_laser(Ice& s) {
  WireRig<IceRig>& rig = s.rig;
  const Result armed = s.command(
      "laser_point", [&](std::int64_t t, Effects& fx) { rig.laser.arm(int(s.random(2)), 100, 0.01, t, fx); });
  if (armed.outcome != Outcome::kReady) return;
  const Result r = s.command("laser_point", [&](std::int64_t t, Effects& fx) { rig.laser.collect(t, fx); });
  if (r.outcome == Outcome::kDone) s.judge(r.counted == 0, "values without a signal", r);
}

void run_heater(Ice& s) {
  WireRig<IceRig>& rig = s.rig;
  const double set = 15.0 + double(s.random(10));
  const Result r = s.command("heater", [&](std::int64_t t, Effects& fx) {
    rig.heater.set({set, set, set}, t, fx);
  });
  const plant::Heat& heat = rig.world.ice()->nature().heat();
  if (r.outcome == Outcome::kDone)
    s.judge(heat.set_degC(0) == set && heat.set_degC(2) == set, "set points", r);
}

}  // namespace

void exchange_under_faults(RealWire::Kind kind, std::int64_t exchanges, std::uint64_t seed,
                           const std::function<void(const ExchangeFigures&)>& done, std::string_view only) {
  const auto inkjet = [&](const char* name, const std::function<void(Inkjet&)>& job) {
    if (!only.empty() && only != name) return;
    Inkjet s(kind, name, seed, inkjet_world());
    while (!s.enough(exchanges)) job(s);
    done(s.done());
  };
  if (only.empty() || only == "camera") {
    Watch s(kind, "camera", seed, watched_world());
    while (!s.enough(exchanges)) run_camera(s);
    done(s.done());
  }
  if (only.empty() || only == "gas") {
    Gases s(kind, "gas", seed, aerosol_world());
    while (!s.enough(exchanges)) run_gas(s);
    done(s.done());
  }
  if (only.empty() || only == "platen") {
    Platen s(kind, "heater", seed, aerosol_world());
    while (!s.enough(exchanges)) run_platen(s);
    ExchangeFigures figures = s.done();
    figures.instrument = "platen";
    done(figures);
  }
  inkjet("stage", run_stage);
  inkjet("jet", run_jet);
  inkjet("laser_profiler", run_profiler);
  inkjet("lamp", run_lamp);
  const auto ice = [&](const char* name, const std::function<void(Ice&)>& job) {
    if (!only.empty() && only != name) return;
    Ice s(kind, name, seed);
    while (!s.enough(exchanges)) job(s);
    done(s.done());
  };
  std::int64_t path = 0;
  ice("robot", [&](Ice& s) { run_path(s, ++path); });
  path = 0;
  ice("valve_a", [&](Ice& s) { run_path(s, ++path); });
  ice("laser_point", run_laser);
  ice("heater", run_heater);
}

}  // namespace firn::drivers::test
