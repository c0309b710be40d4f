#include "cli/plan_command.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <thread>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/output_files.h"
#include "cli/plan_aerosol.h"
#include "config/error.h"
#include "core/motion/curve/given_curves.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/path/path_file.h"
#include "files/path/trajectory_file.h"
#include "files/usage_error.h"
#include "print/interrupt.h"
#include "print/prepare/motion_program.h"
#include "print/prepare/plan_job.h"
#include "print/prepare/plan_outputs.h"
#include "print/progress.h"
#include "report/paths/plan_plot.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

constexpr std::size_t kShownFaults = 20, kShownPaths = 20, kTraceSamples = 4000;

struct Interrupted {};

struct TooManyFaults {};

class PlanRun {
 public:
  PlanRun(const PlanCommandOptions& options, const Machine& machine, const motion::PlanOptions& plan)
      : o_(options), machine_(machine), arm_(make_arm(machine)) {
    TrajectoryHead head{machine.name, o_.method, "firn " + build_commit(), machine.tick_s, origin(), {}, {}};
    for (int j = 0; j < arm_->joints(); ++j) {
      head.axis_names.push_back(arm_->joint_name(j));
      head.axis_units.push_back(arm_->joint_unit(j));
    }
    if (!o_.output.empty()) trajectories_.emplace(o_.output, head);
    if (!o_.csv.empty()) {
      csv_.emplace(o_.csv);
      csv_->write(csv_header(head.axis_units));
    }
    if (!o_.pulses.empty()) {
      pulses_.emplace(o_.pulses);
      pulses_->write("path,list,start_s,tick\n");
    }
    if (!o_.gcode.empty()) {
      gcode_.emplace(o_.gcode);
      gcode_->write(gcode_head(machine.name, o_.method));
    }
    if (!o_.pvt.empty()) open_pvt(head.axis_units);
    PlanJobOptions job{plan,
                       origin(),
                       threads(),
                       0,
                       false,
                       pulses_.has_value(),
                       [this](PlannedItem& item) { describe(item); }};
    job.point_noise_mm = o_.point_noise_mm;
    job.plan.axis_rates = pvt_.has_value();
    if (!o_.plot.empty()) {
      job.traced = o_.plot_path;
      job.plan.trace_step_s = machine.tick_s / 16.0;
    }
    how_ = job;
    job_.emplace(machine, job, [this](PlannedItem&& item) { take(std::move(item)); });
  }

  void add(InputPath&& path) {
    if (InterruptGuard::raised()) throw Interrupted();
    if (const auto warning = slow_path_warning(o_.method, path.place, path.path.points.size()))
      std::fprintf(stderr, "firn plan: note: %s\n", warning->c_str());
    if (o_.json && read_++ == 0) std::fputs("{\"trajectories\": [", stdout);
    job_->add(std::move(path));
  }

  void note(const std::string& sentence) { notes_.push_back(sentence); }
  void travelled(double mm) { travel_mm_ = mm; }

  int finish() {
    job_->finish();
    if (InterruptGuard::raised()) throw Interrupted();
    if (!faults_.empty()) return report_faults();
    if (!o_.plot.empty() && picture_.empty())
      throw UsageError(fmt::format("--plot-path {}: the file has {} paths", o_.plot_path, paths_));
    if (trajectories_) trajectories_->finish();
    if (csv_) csv_->finish();
    if (pulses_) pulses_->finish();
    if (gcode_) {
      gcode_->write(gcode_tail());
      gcode_->finish();
    }
    if (pvt_) pvt_->finish();
    if (!picture_.empty()) {
      TextOutput plot(o_.plot);
      plot.write(picture_);
      plot.finish();
    }
    report();
    return kOk;
  }

  int report_faults() const {
    if (o_.json) {
      std::fputs(("], \"faults\": " + nlohmann::json(faults_).dump() + "}\n").c_str(), stdout);
    } else {
      for (const std::string& f : faults_) std::fprintf(stderr, "firn plan: %s\n", f.c_str());
      std::fputs("firn plan: nothing was written\n", stderr);
    }
    return kFailed;
  }

 private:
  Point2 origin() const { return o_.origin_mm.empty() ? Point2{} : Point2{o_.origin_mm[0], o_.origin_mm[1]}; }
  int threads() const {
    return o_.threads > 0 ? o_.threads : int(std::max(1u, std::thread::hardware_concurrency()));
  }

  void fault(const std::string& what) {
    faults_.push_back(what);
    if (faults_.size() >= kShownFaults) throw TooManyFaults();
  }

  void take(PlannedItem&& item) {
    if (InterruptGuard::raised()) throw Interrupted();
    ++paths_;
    points_ += std::int64_t(item.input.path.points.size());
    deposited_mm_ += item.length_mm;
    if (!item.result.ok()) return fault(item.input.place + ": " + motion::describe(*item.result.fault));
    const Certificate& c = item.result.trajectory.certificate;
    take_worst(worst_, c, item.input.number);
    samples_ += std::int64_t(item.result.trajectory.samples());
    added_stops_ += std::int64_t(item.added_stops.size());
    duration_s_ += c.duration_s;
    lower_bound_s_ += c.lower_bound_s;
    if (trajectories_) trajectories_->add(item.encoded, item.result.trajectory.samples(), c.duration_s);
    if (!item.problem.empty()) return fault(item.problem);
    if (csv_) csv_->write((paths_ > 1 ? "\n" : "") + item.csv);
    if (pulses_) pulses_->write(item.pulses);
    if (gcode_) gcode_->write(item.gcode);
    if (pvt_) pvt_->write(item.pvt);
    if (!o_.plot.empty() && item.input.number == o_.plot_path) draw(item);
    if (o_.json)
      std::fputs(((paths_ > 1 ? ",\n  " : "\n  ") + item.json).c_str(), stdout);
    else if (paths_ <= std::int64_t(kShownPaths))
      print(item);
    progress_.show(item.input.fraction, fmt::format("{} paths", paths_));
  }

  // Of one path, by the thread that planned it.
  void describe(PlannedItem& item) const {
    if (csv_) item.csv = csv_lines(item);
    if (o_.json) item.json = item_json(item);
    if (pulses_) item.pulses = pulse_lines(item);
    if (gcode_) item.gcode = gcode_lines(item);
    if (pvt_) item.pvt = pvt_lines(item, axes_);
  }

  std::string pulse_lines(const PlannedItem& item) const {
    const deposition::PulsePlan& plan = item.pulse_plan;
    std::string lines;
    for (std::size_t n = 0; n < plan.trains.size(); ++n)
      for (std::uint16_t tick : plan.trains[n].ticks)
        fmt::format_to(std::back_inserter(lines), "{},{},{:.9g},{}\n", item.input.number, n + 1,
                       double(plan.trains[n].first_instant) * item.result.trajectory.tick_s, tick);
    return lines;
  }

  void open_pvt(const std::vector<std::string>& units) {
    for (int j = 0; j < arm_->joints(); ++j) {
      if (units[std::size_t(j)] != "mm")
        throw UsageError(
            fmt::format("--pvt: axis {} of {} is in {}; PVT lines are for stages, whose axes are in mm",
                        arm_->joint_name(j), o_.machine, units[std::size_t(j)]));
      std::string name = arm_->joint_name(j);
      for (char& c : name) c = char(std::toupper(static_cast<unsigned char>(c)));
      axes_.push_back(name);
    }
    pvt_.emplace(o_.pvt);
  }

  void draw(const PlannedItem& item) {
    const report::PlanPlot plot = plot_of(item, o_.method);
    if (plot.trace.size() < 2) return;
    if (o_.beside.empty()) {
      picture_ = report::plan_picture(plot);
      return;
    }
    PlanJobOptions how = how_;
    how.plan.method = *motion::method_named(o_.beside);
    how.plan.axis_rates = how.pulses = false;
    how.describe = nullptr;
    how.threads = 1;
    PlanJob other(machine_, how, [&](PlannedItem&& second) {
      if (!second.result.ok())
        return fault(fmt::format("{}: --beside {}: {}", second.input.place, o_.beside,
                                 motion::describe(*second.result.fault)));
      picture_ = report::plan_pictures_beside(plot, plot_of(second, o_.beside));
    });
    other.add(InputPath(item.input));
    other.finish();
  }

  report::PlanPlot plot_of(const PlannedItem& item, const std::string& method) const {
    report::PlanPlot plot;
    plot.title = fmt::format("Path {}: {:.1f} mm in {:.3f} s, {}", item.input.number, item.length_mm,
                             item.result.trajectory.certificate.duration_s, method);
    std::vector<Point2> buffer;  // a given curve is what the deviation is from, not the chords of its samples
    const auto exact = motion::sample_given(item.input.path.points, item.input.given, buffer).points;
    plot.points.assign(exact.begin(), exact.end());
    if (item.input.path.closed && !plot.points.empty()) plot.points.push_back(plot.points.front());
    plot.deviation_mm = item.result.deviation_mm;
    const std::vector<motion::TraceSample> all =
        item.result.trace.empty() ? report::trace_of_samples(item.result.trajectory, item.result.tool)
                                  : item.result.trace;
    const std::size_t step = std::max<std::size_t>(1, all.size() / kTraceSamples);
    for (std::size_t n = 0; n < all.size(); n += step) plot.trace.push_back(all[n]);
    if (!all.empty() && plot.trace.back().t_s < all.back().t_s) plot.trace.push_back(all.back());
    plot.limits = motion_limits(machine_);
    plot.certificate = item.result.trajectory.certificate;
    for (int j = 0; j < motion::limited_joints(plot.limits, arm_->joints()); ++j) {
      plot.joint_names.push_back(arm_->joint_name(j));
      plot.joint_units.push_back(arm_->joint_unit(j));
    }
    return plot;
  }

  void print(const PlannedItem& item) const {
    const motion::PlanResult& r = item.result;
    const Certificate& c = r.trajectory.certificate;
    const bool held = r.held_mm > 0.0;
    if (paths_ == 1)
      std::printf("%6s %8s %10s %9s %9s %7s %6s %11s%s\n", "path", "points", "length mm", "time s", "bound s",
                  "ratio", "stops", "off path um", held ? "  off points um  (held within)" : "");
    double largest = 0.0;
    for (const LimitRatio& l : c.limits) largest = std::max(largest, l.ratio);
    std::printf("%6lld %8zu %10.2f %9.3f %9.3f %7.4f %6zu %11.2f", static_cast<long long>(item.input.number),
                item.input.path.points.size(), item.length_mm, c.duration_s, c.lower_bound_s, largest,
                r.stops, 1e3 * r.deviation_mm);
    std::puts(held ? fmt::format(" {:>14.3f} {:>14.3f}", 1e3 * r.points_off_mm, 1e3 * r.held_mm).c_str()
                   : "");
    for (const AddedStop& stop : item.added_stops)
      std::printf("       rests at %.2f mm (%s): its pulses need %zu lists\n", stop.along_mm,
                  stop.corner ? "corner" : "no corner near", item.pulse_plan.trains.size());
    if (paths_ == std::int64_t(kShownPaths)) std::puts("   ...  (--json lists every path)");
  }

  void report() const {
    if (o_.json) {
      nlohmann::ordered_json limits = nlohmann::ordered_json::array();
      for (const WorstRatio& w : worst_)
        limits.push_back({{"limit", w.ratio.limit},
                          {"ratio", w.ratio.ratio},
                          {"path", w.path},
                          {"time_s", w.ratio.time_s}});
      nlohmann::ordered_json j{{"machine", machine_.name},
                               {"method", o_.method},
                               {"paths", paths_},
                               {"points", points_},
                               {"deposited_mm", deposited_mm_}};
      if (travel_mm_) j["travel_mm"] = *travel_mm_;
      j.update({{"samples", samples_},
                {"added_stops", added_stops_},
                {"tick_s", machine_.tick_s},
                {"duration_s", duration_s_},
                {"lower_bound_s", lower_bound_s_},
                {"limits", limits},
                {"notes", notes_},
                {"output", o_.output}});
      std::fputs(("\n], " + j.dump().substr(1) + "\n").c_str(), stdout);
      return;
    }
    std::printf("\n%lld paths, %lld points, %.2f mm deposited", static_cast<long long>(paths_),
                static_cast<long long>(points_), deposited_mm_);
    if (travel_mm_) std::printf(", %.2f mm travel", *travel_mm_);
    std::printf(", %.3f s, %lld samples at %g s", duration_s_, static_cast<long long>(samples_),
                machine_.tick_s);
    if (lower_bound_s_ > 0.0) std::printf(", %.3f x the lower bound", duration_s_ / lower_bound_s_);
    if (added_stops_ > 0)
      std::printf("\n%lld rests added so that the pulses fit the valve controller's lists",
                  static_cast<long long>(added_stops_));
    std::printf("\n\n%-24s %8s %6s %9s\n", "limit", "ratio", "path", "at s");
    for (const WorstRatio& w : worst_)
      std::printf("%-24s %8.5f %6lld %9.3f\n", w.ratio.limit.c_str(), w.ratio.ratio,
                  static_cast<long long>(w.path), w.ratio.time_s);
    for (const std::string& sentence : notes_)
      std::fprintf(stderr, "firn plan: note: %s\n", sentence.c_str());
    for (const std::string& file : {o_.output, o_.csv, o_.pulses, o_.gcode, o_.pvt, o_.plot})
      if (!file.empty()) std::fprintf(stderr, "wrote %s\n", file.c_str());
  }

  const PlanCommandOptions& o_;
  const Machine& machine_;
  std::unique_ptr<motion::Arm> arm_;
  std::optional<TrajectoryWriter> trajectories_;
  std::optional<TextOutput> csv_, pulses_, gcode_, pvt_;
  std::vector<std::string> axes_;  ///< names in PVT lines
  PlanJobOptions how_;
  std::optional<PlanJob> job_;
  JobProgress progress_{"plan"};
  std::vector<std::string> faults_, notes_;
  std::vector<WorstRatio> worst_;
  std::string picture_;
  double duration_s_ = 0.0, lower_bound_s_ = 0.0, deposited_mm_ = 0.0;
  std::optional<double> travel_mm_;
  std::int64_t read_ = 0, paths_ = 0, points_ = 0, samples_ = 0, added_stops_ = 0;
};

motion::PlanOptions plan_options(const PlanCommandOptions& o, const Machine& machine) {
  const auto method = motion::method_named(o.method);
  if (!method)
    throw UsageError("--method " + o.method +
                     ": must be one of certified, optimal, thesis, constant, default");
  if (!(o.curvature_ramp_mm > 0.0 && o.curvature_ramp_mm <= 10.0))
    throw UsageError(fmt::format("--ramp {}: must lie in (0, 10] mm", o.curvature_ramp_mm));
  if (o.plot_path < 1) throw UsageError("--plot-path: paths are counted from 1");
  if (!o.beside.empty() && o.plot.empty()) throw UsageError("--beside: only with --plot");
  if (!o.beside.empty() && !motion::method_named(o.beside))
    throw UsageError("--beside " + o.beside +
                     ": must be one of certified, optimal, thesis, constant, default");
  motion::PlanOptions plan;
  plan.method = *method;
  plan.tolerance_mm = o.tolerance_mm.value_or(0.0);
  plan.point_rule = o.tolerance_mm ? motion::PointRule::kHeld : motion::PointRule::kFaster;
  if (!(o.fill_mm_s > 0.0 && o.fill_mm_s <= 1e6))
    throw UsageError(fmt::format("--fill-speed {}: must lie in (0, 1e6] mm/s", o.fill_mm_s));
  plan.constant_fill_mm_s = o.fill_mm_s;
  plan.tick_s = machine.tick_s;
  plan.curvature_ramp_mm = o.curvature_ramp_mm;
  return plan;
}

void check_common(const PlanCommandOptions& o) {
  const double tolerance_mm = o.tolerance_mm.value_or(0.0);
  if (!(tolerance_mm >= 0.0 && tolerance_mm <= 10.0))
    throw UsageError(fmt::format("--tolerance {}: must lie in [0, 10] mm", tolerance_mm));
  const double noise_mm = o.point_noise_mm.value_or(0.0);
  if (!(noise_mm >= 0.0 && noise_mm <= 1.0))
    throw UsageError(fmt::format("--point-noise {}: must lie in [0, 1] mm", noise_mm));
  for (double v : o.origin_mm)
    if (!(v >= -kMaxCoordinate_mm && v <= kMaxCoordinate_mm))
      throw UsageError(fmt::format("--origin: {} must lie within +-{} mm", v, kMaxCoordinate_mm));
}

}  // namespace

std::optional<std::string> slow_path_warning(const std::string& method, const std::string& place,
                                             std::size_t points) {
  constexpr double kPerPoint_s = 5e-3;  // samples 0.1 mm apart; method certified takes 6e-5 s
  constexpr double kPerPoint_GB = 2.2e-5, kWindow_GB = 0.05;
  constexpr double kSaid_s = 10.0;
  const double cost_s = kPerPoint_s * double(points);
  if (method != "optimal" || cost_s < kSaid_s) return std::nullopt;
  return fmt::format(
      "{}: method optimal may take {:.0f} s and {:.1f} GB for its {} points; certified is 80 times as fast",
      place, cost_s, kWindow_GB + kPerPoint_GB * double(points), points);
}

int run_plan(const PlanCommandOptions& o) {
  check_common(o);
  check_output_files({o.paths, o.machine}, {o.output, o.csv, o.pulses, o.gcode, o.pvt, o.plot});
  check_ending("--gcode", o.gcode, kGcodeEndings);
  const Machine machine = load_machine(o.machine);
  if (machine.kind == "aerosol") return run_plan_aerosol(machine, o);
  if (!o.corner.empty())
    throw UsageError("--corner: only for an aerosol machine; " + o.machine + " is of kind \"" + machine.kind +
                     "\"");
  const motion::PlanOptions plan = plan_options(o, machine);
  InterruptGuard guard;
  PlanRun run(o, machine, plan);
  try {
    read_paths(o.paths, {[&](InputPath&& path) { run.add(std::move(path)); },
                         [&](const std::string& sentence) { run.note(sentence); },
                         [&](double mm) { run.travelled(mm); }});
    return run.finish();
  } catch (const TooManyFaults&) {
    return run.report_faults();
  } catch (const Interrupted&) {
    std::fputs("firn plan: interrupted; nothing was written\n", stderr);
    return kInterrupted;
  }
}

void declare_plan(OptionSet& options) {
  auto& o = options.calls(run_plan);
  options.option("PATHS", o.paths, "*.csv, *.json, *.gcode, *.svg, *.dxf or *.paths; docs/commands/plan.md")
      .required();
  options.option("-o,--output", o.output, "trajectory file");
  options.option("--machine", o.machine, "machine file, as labs/cobra600.toml").required();
  options.option("--origin", o.origin_mm, "X,Y [mm]: where the paths' frame stands in the machine's")
      .separated_by(',')
      .number_of_values(2);
  options.option("--method", o.method, "certified, optimal, thesis, constant or default").show_default();
  options.option("--fill-speed", o.fill_mm_s, "of straight fill with method constant [mm/s]: 100 or 125")
      .show_default();
  options.option(
      "--tolerance", o.tolerance_mm,
      "the curve stays within so many mm of the points' polygon; 0: it passes every point within "
      "its rounding, or 0.2 um; default: as 0, or through the points but for ramps (--ramp) where that is "
      "faster; of an aerosol machine 0.05");
  options.option("--point-noise", o.point_noise_mm,
                 "largest rounding of a coordinate [mm]; default: half of the points' last decimal");
  options.option("--ramp", o.curvature_ramp_mm, "every jump of curvature is ramped over so many mm")
      .show_default();
  options.option("--corner", o.corner, "of an aerosol machine: paper, loop (default) or hybrid");
  options.option("--csv", o.csv, "t_s,x_mm,y_mm,joint_1,joint_2 at the tick");
  options.option("--pulses", o.pulses, "valve pulses of each path: path,list,start_s,tick");
  options.option("--gcode", o.gcode, "G-code program: a G1 with its feed per tick");
  options.option("--pvt", o.pvt, "Aerotech position-velocity-time lines, one per tick; of a stage");
  options.option(
      "--plot", o.plot,
      "SVG: speed, acceleration, jerk, joints, each limit's activity, the path by speed and deviation");
  options.option("--beside", o.beside, "--plot: the same path by this method beside it");
  options.option("--plot-path", o.plot_path, "number of the path to draw").show_default();
  options.thread_option(o.threads);
  options.json_flag(o.json);
}

}  // namespace firn
