#include "procs/controller/line_node.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include "config/aerosol_lab.h"
#include "core/vision/lines.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr LineReading kUnread{kNone, kNone, kNone, kNone, kNone};

HeightMap less(HeightMap a, const HeightMap& b) {
  if (b.size() != a.size()) return a;
  for (std::size_t c = 0; c < a.size(); ++c) a.cells[c] -= b.cells[c];
  return a;
}

std::vector<LineReading> read_lines(const HeightMap& picture, const std::vector<LineStation>& stations,
                                    const vision::LineLook& look) {
  std::vector<LineReading> readings;
  for (const LineStation& s : stations)
    readings.push_back(vision::measure_line(picture, s, look).value_or(kUnread));
  return readings;
}

}  // namespace

LineControllerNode::LineControllerNode(const Experiment& e, const Machine& machine, PrintJob job)
    : changes_(e),
      controller_(line_setup(e, machine, std::move(job))),
      grid_(e.grid),
      width_mm_(e.aerosol.line_width_mm) {
  subscribe(channels::kHeightMap, this);
  subscribe(channels::kOperatorCommand, this);
}

control::LineDecision LineControllerNode::decide(const height_map_t& m, line_plan_t& plan) {
  if (from_message(m.grid) != grid_ || m.height_mm.size() != grid_.size())
    throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) +
                                ": the grid is not the experiment's");
  HeightMap height = measured_height_of(m);
  if (m.layer == 0) bare_ = height;
  if (m.layer != newest_layer_) before_ = std::move(newest_);
  newest_ = std::move(height);
  newest_layer_ = m.layer;

  vision::LineLook look;
  look.noise_mm = m.noise_std_mm;
  control::LineMeasurement measured;
  measured.layer = m.layer;
  measured.attempt = m.attempt;
  measured.start_error_mm = measured.end_error_mm = kNone;
  measured.total = measured.last = std::vector<LineReading>(controller_.stations().size(), kUnread);
  if (m.layer > 0) {
    measured.total = read_lines(less(newest_, bare_), controller_.stations(), look);
    const HeightMap last = less(newest_, before_);
    measured.last = read_lines(last, controller_.stations(), look);
    double sum[2] = {}, seen[2] = {};
    for (const LineEnd& end : controller_.ends())
      if (const auto error = vision::measure_end(last, end, width_mm_, look)) {
        sum[end.start] += *error;
        seen[end.start] += 1.0;
      }
    if (seen[1] > 0.0) measured.start_error_mm = sum[1] / seen[1];
    if (seen[0] > 0.0) measured.end_error_mm = sum[0] / seen[0];
  }
  plan.start_error_mm = measured.start_error_mm;
  plan.end_error_mm = measured.end_error_mm;
  for (std::size_t s = 0; s < controller_.stations().size(); ++s) {
    const LineReading& total = measured.total[s];
    plan.station_x_mm.push_back(float(controller_.stations()[s].at.x_mm));
    plan.station_y_mm.push_back(float(controller_.stations()[s].at.y_mm));
    plan.area_mm2.push_back(float(total.area_mm2));
    plan.layer_area_mm2.push_back(float(measured.last[s].area_mm2));
    plan.width_mm.push_back(float(total.width_mm));
    plan.offset_mm.push_back(float(total.offset_mm));
    plan.overspray.push_back(float(std::clamp(total.overspray, -1.0, 1.0)));
  }
  return controller_.decide(measured);
}

void LineControllerNode::on(const height_map_t& m, Time, Outbox& out) {
  line_plan_t plan{};
  plan.layer = m.layer + 1;
  plan.attempt = m.attempt;
  plan.map_id = m.map_id;
  plan.flow_share = 1.0;
  plan.start_error_mm = plan.end_error_mm = kNone;
  control::LineDecision d;
  try {
    d = decide(m, plan);
  } catch (const std::exception& error) {
    d = {};
    d.kind = PlanDecision::kStop;
    d.reason = error.what();
    fault_t fault{};
    fault.severity = std::int8_t(Severity::kStop);
    fault.node = info(NodeId::kController).name;
    fault.text = error.what();
    out.send(channels::fault(NodeId::kController), fault);
  }
  plan.decision = std::int8_t(d.kind);
  plan.reason = d.reason;
  if (d.kind == PlanDecision::kPrint) plan.path = ++paths_;
  plan.duration_s = d.duration_s;
  plan.open_s = d.open_s;
  plan.printed_mm = d.printed_mm;
  plan.open_delay_s = d.open_delay_s;
  plan.close_delay_s = d.close_delay_s;
  plan.flow_share = d.flow_share;
  plan.t_s = std::move(d.way.t_s);
  plan.x_mm = std::move(d.way.x_mm);
  plan.y_mm = std::move(d.way.y_mm);
  plan.vx_mm_s = std::move(d.way.vx_mm_s);
  plan.vy_mm_s = std::move(d.way.vy_mm_s);
  plan.switch_mm = std::move(d.way.switch_mm);
  plan.speed_mm_s.assign(d.speed_mm_s.begin(), d.speed_mm_s.end());
  plan.stations = std::int32_t(plan.station_x_mm.size());
  plan.speed_mm_s.resize(std::size_t(plan.stations));
  plan.knots = std::int32_t(plan.t_s.size());
  plan.switches = std::int32_t(plan.switch_mm.size());
  out.send(channels::kLinePlan, std::move(plan));
}

void LineControllerNode::on(const operator_command_t& m, Time, Outbox&) {
  if (OperatorVerb(m.verb) != OperatorVerb::kSet || !changes_.take(m.command_id)) return;
  if (changes_.set(m.key, m.value).empty())
    controller_.use_options(changes_.experiment().aerosol, changes_.experiment().control.smf);
}

}  // namespace firn
