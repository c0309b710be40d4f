#include "tests/firmware/trigger_chain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "files/run_paths.h"
#include "firn/enums.h"
#include "firn/pulse_list_t.hpp"
#include "firn/trajectory_t.hpp"
#include "firn/valve_command_t.hpp"
#include "plant/record/record.h"
#include "runs/read/run_reader.h"

namespace firn::test {
namespace {

constexpr double kMs = 1e-3;  // a record's microseconds

struct Run {
  std::int64_t signal_us = 0, rest_us = 0;
  std::int64_t mask = 0;
};

// Motions that a signal has started, in order of time. The record notes a motion when it is ordered; the arm
// begins later, so that its begin is counted back from its end.
std::vector<Run> runs_of(const plant::WorldHistory& world) {
  std::vector<Run> runs;
  std::int64_t mask = 0;
  for (const plant::DeviceRecord& d : world.devices) {
    if (d.event == plant::DeviceEvent::kSignals) {
      if (mask == 0 && d.value != 0) runs.push_back({d.t_us, 0, d.value});
      mask = d.value;
    } else if (d.event == plant::DeviceEvent::kRobotRest && !runs.empty() && runs.back().rest_us == 0) {
      runs.back().rest_us = d.t_us;
    }
  }
  return runs;
}

void sum_up(ChainPart& part) {
  if (part.paths.empty()) return;
  double products = 0.0, squares = 0.0;
  for (const ChainPath& p : part.paths) {
    part.mean_ms += 0.5 * (p.begin_ms + p.end_ms) / double(part.paths.size());
    products += (p.end_ms - p.begin_ms) * 1e-3 * p.span_s;
    squares += p.span_s * p.span_s;
  }
  part.drift_ppm = products / squares * 1e6;
  for (const ChainPath& p : part.paths)
    part.worst_ms =
        std::max({part.worst_ms, std::abs(p.begin_ms - part.mean_ms), std::abs(p.end_ms - part.mean_ms)});
}

}  // namespace

std::vector<ChainPart> trigger_chain(const std::filesystem::path& run, const plant::IceArmParams& arm,
                                     const plant::IceLaserParams& laser) {
  const plant::WorldHistory world = plant::read_history(RunPaths(run).world_record_path());
  const runs::RunReader messages(run);
  std::map<std::int64_t, double> span_s;  // of a path's motion, by its number
  messages.each<trajectory_t>(channels::kTrajectory.name, [&](const trajectory_t& t) {
    span_s[t.path] = double(t.samples - 1) * t.tick_s;
  });
  std::map<std::pair<std::int64_t, int>, pulse_list_t> lists;
  messages.each<pulse_list_t>(channels::kPulseList.name, [&](const pulse_list_t& l) {
    lists[{l.path, l.valve}] = l;
  });
  struct Arming {
    std::int64_t t_us, path;
    int valve;
  };
  std::vector<Arming> armings;
  for (const auto& [channel, valve] : {std::pair{channels::kValveACommand, 1}, {channels::kValveBCommand, 2}})
    messages.each<valve_command_t>(channel.name, [&, valve = valve](const valve_command_t& c) {
      if (ValveVerb(c.verb) == ValveVerb::kArm) armings.push_back({c.header.utime_us, c.path, valve});
    });
  const std::vector<Run> runs = runs_of(world);
  const double arm_clock = 1.0 + arm.clock_ppm * 1e-6, laser_clock = 1.0 + laser.clock_ppm * 1e-6;

  std::vector<ChainPart> parts{{"valve_a", {}}, {"valve_b", {}}, {"laser_point", {}}};
  for (const plant::FiringRecord& f : world.firings) {
    std::int64_t path = 0;
    for (const Arming& a : armings)
      if (a.valve == f.valve + 1 && a.t_us <= f.trigger_us) path = std::max(path, a.path);
    const auto list = lists.find({path, f.valve + 1});
    const auto its_run = std::ranges::find(runs, f.trigger_us, &Run::signal_us);
    if (f.fired < 2 || list == lists.end() || its_run == runs.end() || list->second.lists != 1) continue;
    const pulse_list_t& l = list->second;
    const double span = span_s.at(path), begin_ms = double(its_run->rest_us) * kMs - span * 1e3 * arm_clock;
    const auto late_ms = [&](std::int64_t pulse_us, std::int32_t tick) {
      return double(pulse_us) * kMs - begin_ms - double(tick) * l.tick_s * 1e3 * arm_clock;
    };
    parts[f.valve].paths.push_back(
        {path, span, late_ms(f.first_us, l.tick.front()), late_ms(f.last_us, l.tick.back())});
  }
  for (const Run& r : runs) {
    constexpr int kLaser = 4;
    if ((r.mask & kLaser) == 0) continue;
    // The motion lasts whole ticks of the robot's clock.
    constexpr double kTick_s = 0.016;
    const double about_s = double(r.rest_us - r.signal_us) * 1e-6 - arm.start_delay_s;
    const double span = std::floor(about_s / kTick_s + 0.5) * kTick_s;
    const double begin_ms = double(r.rest_us) * kMs - span * 1e3 * arm_clock;
    const double late_ms = double(r.signal_us) * kMs + laser.trigger_delay_s * 1e3 - begin_ms;
    parts[2].paths.push_back({0, span, late_ms, late_ms + span * 1e3 * (laser_clock - arm_clock)});
  }
  for (ChainPart& part : parts) sum_up(part);
  return parts;
}

}  // namespace firn::test
