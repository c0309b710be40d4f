#include "cli/plan_aerosol.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdio>

#include "config/aerosol_lab.h"
#include "core/motion/aerosol/plan.h"
#include "core/motion/kinematics/fault.h"
#include "core/path/line_overlap.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/path/print_job_file.h"
#include "files/path/trajectory_file.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "report/paths/aerosol_pictures.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;
using motion::AerosolPlan;
using motion::AerosolReport;
using motion::CornerMode;

constexpr CornerMode kModes[] = {CornerMode::kPaper, CornerMode::kLoop, CornerMode::kHybrid};

constexpr double kCornerTolerance_mm = 0.05;  // of hybrid corners, where --tolerance is not given

CornerMode mode_named(const std::string& word) {
  for (const CornerMode mode : kModes)
    if (word == name(mode)) return mode;
  throw UsageError("--corner " + word + ": must be one of paper, loop, hybrid");
}

Point2 origin_of(const PlanCommandOptions& o) {
  return o.origin_mm.empty() ? Point2{} : Point2{o.origin_mm[0], o.origin_mm[1]};
}

void shift(PrintJob& job, const Point2& by) {
  const auto move = [&](Point2& p) { p = {p.x_mm + by.x_mm, p.y_mm + by.y_mm}; };
  move(job.start);
  move(job.end);
  for (PrintSegment& s : job.segments) {
    move(s.from);
    move(s.to);
  }
}

std::string refusal(const std::string& file, const motion::Refusal& r) {
  return fmt::format("{}: segments[{}]: {}", file, r.segment, r.reason);
}

Json extreme_json(const motion::Extreme& e) {
  return {{"value", e.value}, {"t_s", e.t_s}, {"segment", e.segment}};
}

Json json_of(const AerosolPlan& plan, CornerMode mode) {
  Json json{{"corner", name(mode)}, {"refused", Json::array()}};
  for (const motion::Refusal& r : plan.refused)
    json["refused"].push_back({{"segment", r.segment}, {"reason", r.reason}});
  if (!plan.ok()) return json;
  const AerosolReport& r = plan.report;
  json.update({{"total_s", r.total_s},
               {"print_s", r.print_s},
               {"transit_s", r.transit_s},
               {"wasted_mm3", r.wasted_mm3},
               {"lower_bound_s", r.lower_bound_s},
               {"loops", r.loops},
               {"rounded", r.rounded},
               {"transits", r.transits},
               {"speed_error", extreme_json(r.speed_error)},
               {"position_error_mm", extreme_json(r.position_error_mm)},
               {"path_error_mm", extreme_json(r.path_error_mm)},
               {"longest_corner_s", extreme_json(r.corner_s)},
               {"axis_speed_ratio", extreme_json(r.axis_speed_ratio)},
               {"axis_acceleration_ratio", extreme_json(r.axis_acceleration_ratio)}});
  return json;
}

std::string report_line(const AerosolPlan& plan, CornerMode mode, bool chosen) {
  const std::string front = fmt::format("{} {:<7}", chosen ? '*' : ' ', name(mode));
  if (!plan.ok())
    return front + fmt::format(" refused: {} segments, the first: segments[{}]: {}\n", plan.refused.size(),
                               plan.refused[0].segment, plan.refused[0].reason);
  const AerosolReport& r = plan.report;
  return front + fmt::format(" {:9.3f} {:9.3f} {:9.3f} {:11.5f} {:8.3f} {:11.3f} {:10.3f} {:6} {:8}\n",
                             r.total_s, r.print_s, r.transit_s, r.wasted_mm3, 100 * r.speed_error.value,
                             1e3 * r.position_error_mm.value, 1e3 * r.path_error_mm.value, r.loops,
                             r.rounded);
}

// Shortest digits that read back the same.
std::string csv(const AerosolPlan& plan, const motion::AerosolMachine& machine) {
  const Trajectory stage = motion::sample_stage(plan, machine);
  const std::vector<motion::ShutterCommand> commands = motion::shutter_commands(plan, machine);
  std::string text = "t_s,x_mm,y_mm,joint_1_mm,joint_2_mm,shutter_command\n";
  std::size_t next = 0;
  for (std::size_t n = 0; n < stage.samples(); ++n) {
    const double t = double(n) * stage.tick_s;
    while (next < commands.size() && commands[next].t_s <= t + 1e-12) ++next;
    const Point2 p = motion::state_at(plan, std::min(t, plan.duration_s())).p_mm;
    text += fmt::format("{},{},{},{},{},{}\n", t, p.x_mm, p.y_mm, stage.positions[2 * n],
                        stage.positions[2 * n + 1], next > 0 && commands[next - 1].open ? 1 : 0);
  }
  return text;
}

void write_stage(const AerosolPlan& plan, const motion::AerosolMachine& machine, const Machine& config,
                 const PlanCommandOptions& o, const std::string& corner) {
  PlannedPath path;
  path.trajectory = motion::sample_stage(plan, machine);
  path.trajectory.id = 1;
  for (std::size_t n = 2; n + 1 < path.trajectory.positions.size(); n += 2)
    path.path_mm += std::hypot(path.trajectory.positions[n] - path.trajectory.positions[n - 2],
                               path.trajectory.positions[n + 1] - path.trajectory.positions[n - 1]);
  TrajectoryWriter out(o.output, {config.name,
                                  corner,
                                  "firn " + build_commit(),
                                  path.trajectory.tick_s,
                                  origin_of(o),
                                  {"x", "y"},
                                  {"mm", "mm"}});
  out.add(path);
  out.finish();
  std::fprintf(stderr, "wrote %s\n", o.output.c_str());
}

void check_aerosol(const PlanCommandOptions& o) {
  if (o.method != "certified")
    throw UsageError("--method: not for an aerosol machine; it has --corner paper, loop or hybrid");
  if (!o.gcode.empty() || !o.pvt.empty() || !o.beside.empty())
    throw UsageError("--gcode, --pvt, --beside: not for an aerosol machine");
  if (!o.pulses.empty())
    throw UsageError("--pulses: not for an aerosol machine, whose shutter stands in the CSV");
}

}  // namespace

int run_plan_aerosol(const Machine& config, const PlanCommandOptions& o) {
  check_aerosol(o);
  const std::string corner = o.corner.empty() ? "loop" : o.corner;
  const CornerMode chosen = mode_named(corner);
  const motion::AerosolMachine machine = aerosol_machine(config);
  PrintJob job = read_print_job(o.paths);
  shift(job, origin_of(o));
  std::vector<AerosolPlan> plans;
  try {
    for (const CornerMode mode : kModes)
      plans.push_back(
          motion::plan_aerosol(job, machine, {mode, o.tolerance_mm.value_or(kCornerTolerance_mm)}));
  } catch (const motion::MotionError& e) {
    throw UsageError(e.what());
  }
  const AerosolPlan& plan = plans[std::size_t(chosen)];
  if (o.json) {
    Json json{{"machine", config.name},
              {"job", o.paths},
              {"corner", corner},
              {"modes", Json::array()},
              {"shutter_commands", Json::array()}};
    for (const CornerMode mode : kModes) json["modes"].push_back(json_of(plans[std::size_t(mode)], mode));
    for (const motion::ShutterCommand& c : motion::shutter_commands(plan, machine))
      json["shutter_commands"].push_back({{"t_s", c.t_s}, {"open", c.open}});
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    std::printf("%-9s %9s %9s %9s %11s %8s %11s %10s %6s %8s\n", "  corner", "total s", "print s",
                "transit s", "wasted mm3", "speed %", "position um", "path um", "loops", "rounded");
    for (const CornerMode mode : kModes)
      std::fputs(report_line(plans[std::size_t(mode)], mode, mode == chosen).c_str(), stdout);
  }
  if (!plan.ok()) {
    for (const motion::Refusal& r : plan.refused)
      std::fprintf(stderr, "firn plan: %s\n", refusal(o.paths, r).c_str());
    std::fputs("firn plan: nothing was written\n", stderr);
    return kFailed;
  }
  for (const std::string& r : overlap_remarks(job))
    std::fprintf(stderr, "remark: %s: %s\n", o.paths.c_str(), r.c_str());
  const auto write = [](const std::string& file, const std::string& text) {
    if (file.empty()) return;
    write_file_atomically(file, text);
    std::fprintf(stderr, "wrote %s\n", file.c_str());
  };
  if (!o.output.empty()) write_stage(plan, machine, config, o, corner);
  write(o.csv, o.csv.empty() ? "" : csv(plan, machine));
  write(o.plot, o.plot.empty() ? ""
                               : report::aerosol_plot(job, plan, machine,
                                                      fmt::format("{}, --corner {}", o.paths, corner)));
  return kOk;
}

}  // namespace firn
