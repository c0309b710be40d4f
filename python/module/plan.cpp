#include <fmt/format.h>

#include <cmath>

#include "config/machine.h"
#include "core/motion/trajectory/plan.h"
#include "print/prepare/plan_job.h"
#include "print/prepare/plan_outputs.h"
#include "python/module/module.h"

namespace firn::python {
namespace {

constexpr int kPlanarAxes = 2;  // that move the tool in the plane, as in the command's table

InputPath path_of(const Doubles& points, bool closed) {
  if (points.ndim() != 2 || points.shape(1) != 2 || std::size_t(points.shape(0)) > kMaxPathPoints)
    throw std::invalid_argument(
        fmt::format("points_mm: the shape is not (n, 2) with n at most {}", kMaxPathPoints));
  InputPath input;
  input.number = 1;
  input.place = "points_mm";
  input.path.closed = closed;
  const auto at = points.unchecked<2>();
  for (py::ssize_t n = 0; n < points.shape(0); ++n) {
    for (const double v : {at(n, 0), at(n, 1)})
      if (!(std::abs(v) <= kMaxCoordinate_mm))
        throw std::invalid_argument(
            fmt::format("points_mm[{}]: {} must lie within +-{} mm", n, v, kMaxCoordinate_mm));
    input.path.points.push_back({at(n, 0), at(n, 1)});
  }
  return input;
}

motion::PlanOptions options_of(const Machine& machine, const std::string& method, double tolerance_mm) {
  const auto known = motion::method_named(method);
  if (!known)
    throw std::invalid_argument("method \"" + method +
                                "\": must be one of certified, optimal, thesis, constant, default");
  if (!(tolerance_mm >= 0.0 && tolerance_mm <= 10.0))
    throw std::invalid_argument(fmt::format("tolerance_mm = {}: must lie in [0, 10]", tolerance_mm));
  motion::PlanOptions options;
  options.method = *known;
  options.tolerance_mm = tolerance_mm;
  options.tick_s = machine.tick_s;
  return options;
}

PlannedItem planned(const Machine& machine, const PlanJobOptions& how, InputPath&& input) {
  PlannedItem found;
  PlanJob job(machine, how, [&](PlannedItem&& item) { found = std::move(item); });
  job.add(std::move(input));
  job.finish();
  if (!found.result.ok())
    throw std::invalid_argument(found.input.place + ": " + motion::describe(*found.result.fault));
  if (!found.problem.empty()) throw std::invalid_argument(found.problem);
  return found;
}

}  // namespace

py::tuple plan(const Doubles& points_mm, const std::string& machine_file, bool closed, double origin_x_mm,
               double origin_y_mm, const std::string& method, double tolerance_mm) {
  const Machine machine = load_machine(machine_file);
  if (machine.kind == "aerosol") throw NeedsProgram(machine_file);
  for (const double v : {origin_x_mm, origin_y_mm})
    if (!(std::abs(v) <= kMaxCoordinate_mm))
      throw std::invalid_argument(fmt::format("origin_mm: {} must lie within +-{} mm", v, kMaxCoordinate_mm));
  PlanJobOptions how;
  how.plan = options_of(machine, method, tolerance_mm);
  how.origin = {origin_x_mm, origin_y_mm};
  InputPath input = path_of(points_mm, closed);
  PlannedItem item;
  {
    const py::gil_scoped_release others_go_on;
    item = planned(machine, how, std::move(input));
  }
  const Trajectory& t = item.result.trajectory;
  const auto samples = py::ssize_t(t.samples());
  py::array_t<double> t_s(samples), tool({samples, py::ssize_t(2)});
  auto time = t_s.mutable_unchecked<1>();
  auto at = tool.mutable_unchecked<2>();
  for (py::ssize_t n = 0; n < samples; ++n) {
    time(n) = double(n) * t.tick_s;
    at(n, 0) = item.result.tool[std::size_t(n)].x_mm;
    at(n, 1) = item.result.tool[std::size_t(n)].y_mm;
  }
  py::dict joints;
  const auto arm = make_arm(machine);
  for (int j = 0; j < kPlanarAxes; ++j) {
    py::array_t<double> one(samples);
    auto q = one.mutable_unchecked<1>();
    for (py::ssize_t n = 0; n < samples; ++n) q(n) = t.positions[std::size_t(n * t.axes + j)];
    joints[fmt::format("joint_{}_{}", j + 1, arm->joint_unit(j)).c_str()] = one;
  }
  return py::make_tuple(item_json(item), t_s, tool, joints);
}

}  // namespace firn::python
