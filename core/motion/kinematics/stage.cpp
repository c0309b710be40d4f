#include <algorithm>
#include <cmath>

#include "core/motion/kinematics/arm.h"

namespace firn::motion {
namespace {

class Stage final : public Arm {
 public:
  explicit Stage(CartesianConfig spec) : spec_(std::move(spec)) {}
  int joints() const override { return int(spec_.ranges.size()); }
  bool turns() const override { return false; }
  std::string joint_name(int joint) const override { return std::string(1, char('x' + joint)); }
  std::string joint_unit(int) const override { return "mm"; }
  JointRange range(int joint) const override { return spec_.ranges[std::size_t(joint)]; }

  std::optional<Fault> inverse(const Jets& task, const ArmConfiguration&, Jets& out) const override {
    const std::size_t count = task.samples();
    for (int axis = 0; axis < std::min(joints(), out.axes()); ++axis)
      for (int order = 0; order < 4; ++order) std::copy_n(task.of(axis, order), count, out.of(axis, order));
    for (std::size_t n = 0; n < count; ++n)
      for (int axis = 0; axis < joints(); ++axis)
        if (auto fault = out_of_range(task, n, axis)) return fault;
    return std::nullopt;
  }

  void forward(const Jets& joints_in, Jets& out) const override {
    for (int axis = 0; axis < kTaskAxes; ++axis)
      for (int order = 0; order < 4; ++order) {
        if (axis < joints())
          std::copy_n(joints_in.of(axis, order), out.samples(), out.of(axis, order));
        else
          std::fill_n(out.of(axis, order), out.samples(), 0.0);
      }
  }

  bool bound_higher(const FlangeBounds& flange, std::span<const JointJet>,
                    std::array<JointVector, 2>& bounds) const override {
    for (std::size_t k = 0; k < 2; ++k) bounds[k] = {flange.position[k], flange.position[k], 0.0};
    return true;
  }

  Jacobian jacobian(const JointVector&) const override {
    Jacobian j{};
    for (int axis = 0; axis < joints(); ++axis) j[std::size_t(axis)][std::size_t(axis)] = 1.0;
    return j;
  }
  Jacobian jacobian_rate(const JointVector&, const JointVector&) const override { return {}; }

  std::optional<Fault> choose_configuration(const Jets& task, const ArmConfiguration& preferred,
                                            ArmConfiguration& chosen) const override {
    Jets none(0, task.samples());
    chosen = preferred;
    return inverse(task, preferred, none);
  }

 private:
  std::optional<Fault> out_of_range(const Jets& task, std::size_t n, int axis) const {
    const double value = task.of(axis, 0)[n];
    const JointRange r = range(axis);
    if (value >= r.low && value <= r.high) return std::nullopt;
    Fault fault{value < r.low ? Reason::kJointLow : Reason::kJointHigh};
    fault.index = n;
    fault.axis = axis;
    fault.value = value;
    fault.bound = value < r.low ? r.low : r.high;
    fault.at = {task.of(kX, 0)[n], task.of(kY, 0)[n]};
    return fault;
  }

  CartesianConfig spec_;
};

}  // namespace

std::unique_ptr<Arm> make_stage(const CartesianConfig& spec) {
  Fault fault{Reason::kOption};
  fault.what = "stage axes";
  fault.value = double(spec.ranges.size());
  fault.bound = 3.0;
  if (spec.ranges.size() < 2 || spec.ranges.size() > 3) throw MotionError(fault);
  for (std::size_t i = 0; i < spec.ranges.size(); ++i) {
    if (spec.ranges[i].low < spec.ranges[i].high) continue;
    fault.axis = int(i);
    fault.what = "range";
    fault.value = spec.ranges[i].low;
    fault.bound = spec.ranges[i].high;
    throw MotionError(fault);
  }
  return std::make_unique<Stage>(spec);
}

}  // namespace firn::motion
