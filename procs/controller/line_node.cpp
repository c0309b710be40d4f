#include "procs/controller/line_node.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include "config/aerosol_lab.h"
#include "core/control/lines/visible_width.h"
#include "core/grid/png.h"
#include "core/vision/lines.h"
#include "firn/enums.h"
#include "lcmtypes/camera_picture.h"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr double kUmPerMm = 1e3;
constexpr std::size_t kBarePictures = 9;  // whose median is the light
constexpr double kDarkest = 1e-3;         // share of the white level that still tells ink from none
constexpr double kBlackest = 0.99;        // contrast; thicker ink looks alike
constexpr double kMinDepths = 0.1;        // optical depths of ink that is no noise
constexpr double kDeepestDepths = 2.0;    // optical depths; of more ink a layer's share is not told
constexpr double kOfPicture = 0.95;       // looked at around an end
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr LineReading kUnread{kNone, kNone, kNone, kNone, kNone};

HeightMap less(HeightMap a, const HeightMap& b) {
  if (b.size() != a.size()) return a;
  for (std::size_t c = 0; c < a.size(); ++c) a.cells[c] -= b.cells[c];
  return a;
}

std::vector<LineReading> read_lines(const HeightMap& picture, const std::vector<LineStation>& stations,
                                    const vision::LineWindow& look) {
  std::vector<LineReading> readings;
  for (const LineStation& s : stations)
    readings.push_back(vision::measure_line(picture, s, look).value_or(kUnread));
  return readings;
}

// The mapper averages along x over a cell, and rows lie at the middles of cells.
HeightMap seen_by_profiler(const HeightMap& surface, const AerosolLabConfig& c) {
  return vision::seen_through(vision::seen_through(surface, surface.spec.pitch_x_mm, 0.0), c.spot_x_mm,
                              c.spot_y_mm);
}

// Mean error of the starts, or of the other ends; NaN where none is known.
double mean_over_ends(const std::vector<LineEnd>& ends, bool starts,
                      const std::function<double(std::size_t)>& error_mm) {
  double sum = 0.0, seen = 0.0;
  for (std::size_t n = 0; n < ends.size(); ++n)
    if (const double e = error_mm(n); ends[n].start == starts && !std::isnan(e)) {
      sum += e;
      seen += 1.0;
    }
  return seen > 0.0 ? sum / seen : kNone;
}

}  // namespace

LineControllerNode::LineControllerNode(const Experiment& e, const Machine& machine, PrintJob job,
                                       const HeightMap& target)
    : changes_(e),
      has_profiler_(has_profiler(e)),
      controller_(line_setup(e, machine, std::move(job))),
      grid_(e.grid),
      width_mm_(e.aerosol.line_width_mm),
      nominal_(read_lines(seen_by_profiler(target, e.aerosol), controller_.stations(), {})),
      growth_(control::VisibleWidth(width_mm_ / control::kWidthPerSigma, e.aerosol.optical_depth_mm)) {
  if (has_profiler_) subscribe(channels::kHeightMap, this);
  subscribe(channels::kOperatorCommand, this);
  if (!firn::on(e.camera.use)) return;
  subscribe(channels::kCameraFrame, this);
  looks_.resize(controller_.stations().size());
  end_looks_.resize(controller_.ends().size());
  told_.resize(end_looks_.size());
  if (!has_profiler_) subscribe(channels::kPathReport, this);
}

void LineControllerNode::on(const camera_frame_t& m, Time, Outbox& out) {
  const std::size_t stations = looks_.size(), places = stations + (has_profiler_ ? 0 : end_looks_.size());
  if (m.sweep_id < 1 || m.sweep_id > std::int64_t(places)) return;
  look_at(m, out);
  if (has_profiler_ || m.sweep_id != std::int64_t(places)) return;
  line_plan_t plan{};
  plan.layer = m.layer + 1;
  plan.attempt = m.attempt;
  answer(
      std::move(plan), [&](line_plan_t& p) { return decide_by_pictures(p, out); }, out);
}

void LineControllerNode::look_at(const camera_frame_t& m, Outbox& out) {
  vision::Frame frame;
  try {
    frame = frame_of(m);
  } catch (const PngError& error) {
    return out.warn("CAMERA_FRAME of line station " + std::to_string(m.sweep_id) + " " + error.what());
  }
  if (m.layer == 0) {
    if (bare_pictures_.size() < kBarePictures) bare_pictures_.push_back(std::move(frame));
    return;
  }
  if (flat_.pixels.empty() && !bare_pictures_.empty()) {
    std::vector<const vision::Frame*> bare;
    for (const vision::Frame& f : bare_pictures_) bare.push_back(&f);
    flat_ = vision::flat_field(bare);
    bare_pictures_.clear();
  }
  if (m.layer != looked_layer_) {
    looks_.assign(looks_.size(), {});
    for (EndLook& e : end_looks_) e.before = std::exchange(e.ink, {});
  }
  looked_layer_ = m.layer;
  const auto k = std::size_t(m.sweep_id - 1);
  if (k < looks_.size())
    looks_[k] = look_along(controller_.stations()[k], frame);
  else
    look_at_end(k - looks_.size(), frame);
}

vision::LinePictureReading LineControllerNode::look_along(const LineStation& s,
                                                          const vision::Frame& frame) const {
  const AerosolLabConfig& c = changes_.experiment().aerosol;
  const double per_px = c.camera_um_per_px / kUmPerMm;
  vision::LineView view;
  view.middle = {0.5 * (frame.width - 1), 0.5 * (frame.height - 1)};
  view.direction = {s.direction.x_mm, -s.direction.y_mm};
  view.length_px = (s.to_mm - s.from_mm) / per_px;
  view.width_px = width_mm_ / per_px;
  view.window_px = std::min(vision::LineWindow{}.half_window_mm * 2.0, 0.5 * s.room_mm) / per_px;
  vision::LinePictureOptions options;
  options.blur_px = c.camera_blur_px;
  return vision::measure_line_picture(frame, flat_.pixels.empty() ? nullptr : &flat_, view, options);
}

// The picture as a map of the ink's thickness around a place.
HeightMap LineControllerNode::ink_around(const Point2& at, const vision::Frame& frame) const {
  const AerosolLabConfig& c = changes_.experiment().aerosol;
  const double mm = c.camera_um_per_px / kUmPerMm;
  const double half_x_mm = 0.5 * (frame.width - 1) * mm, half_y_mm = 0.5 * (frame.height - 1) * mm;
  HeightMap ink({frame.width, frame.height, mm, mm, at.x_mm - half_x_mm, at.y_mm - half_y_mm});
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const double light = double(flat_.at(x, y)) / flat_.white;
      const double left = double(frame.at(x, y)) / frame.white / std::max(kDarkest, light);
      ink.at(x, frame.height - 1 - y) =
          c.optical_depth_mm * control::ink_depths(std::clamp(1.0 - left, 0.0, kBlackest));
    }
  return ink;
}

vision::LineWindow LineControllerNode::end_window(const HeightMap& ink) const {
  vision::LineWindow look;
  look.noise_mm = changes_.experiment().aerosol.optical_depth_mm;
  look.end_before_mm = look.end_inside_mm =
      0.5 * kOfPicture *
      std::min((ink.spec.nx - 1) * ink.spec.pitch_x_mm, (ink.spec.ny - 1) * ink.spec.pitch_y_mm);
  return look;
}

void LineControllerNode::look_at_end(std::size_t n, const vision::Frame& frame) {
  EndLook& seen = end_looks_[n];
  seen.ink = {};
  seen.goes_on = false;
  if (flat_.pixels.size() != frame.pixels.size() || flat_.width != frame.width) return;
  const LineEnd& end = controller_.ends()[n];
  seen.ink = ink_around(end.at, frame);
  const vision::LineWindow look = end_window(seen.ink);
  if (looked_layer_ == 1)
    seen.level_mm = vision::level_inside(seen.ink, end, width_mm_, look).value_or(kNone);
  const auto height_mm = [&](double inwards) {  // of the outer half of that side of the picture
    const double to_mm = 0.75 * look.end_inside_mm * (end.start ? inwards : -inwards);
    LineStation s;
    s.to_mm = 0.5 * look.end_inside_mm;
    s.direction = end.direction;
    s.at = {end.at.x_mm + to_mm * end.direction.x_mm, end.at.y_mm + to_mm * end.direction.y_mm};
    return vision::measure_line(seen.ink, s, {}).value_or(kUnread).height_mm;
  };
  const double inside_mm = height_mm(1.0);
  seen.goes_on = end.free && inside_mm > kMinDepths * changes_.experiment().aerosol.optical_depth_mm &&
                 height_mm(-1.0) > 0.5 * inside_mm;
}

// The end's station got its planned share of the first layer's ink.
double LineControllerNode::end_error_mm(std::size_t n, std::int32_t layer) const {
  const EndLook& seen = end_looks_[n];
  const LineEnd& end = controller_.ends()[n];
  if (seen.ink.size() == 0 || layer != looked_layer_) return kNone;
  const vision::LineWindow look = end_window(seen.ink);
  if (layer == 1) return vision::measure_end(seen.ink, end, width_mm_, look).value_or(kNone);
  if (seen.before.size() != seen.ink.size() || planned_.size() < std::size_t(layer)) return kNone;
  const auto& stations = controller_.stations();
  std::size_t s = 0;
  for (std::size_t k = 0; k < stations.size(); ++k)
    if (stations[k].segment == end.segment && (!end.start || stations[s].segment != end.segment)) s = k;
  const double level_mm = seen.level_mm * planned_[std::size_t(layer - 1)][s] / planned_[0][s];
  if (std::isnan(level_mm)) return kNone;
  const double deepest_mm = kDeepestDepths * changes_.experiment().aerosol.optical_depth_mm;
  return vision::measure_added_end({seen.before, seen.ink, level_mm, deepest_mm}, end, width_mm_, look)
      .value_or(kNone);
}

// After the stop the layer is looked at again; all ink of it is old by then.
std::string LineControllerNode::new_end_that_goes_on(std::int32_t layer) {
  std::string what;
  for (std::size_t n = 0; n < end_looks_.size(); ++n) {
    if (!end_looks_[n].goes_on || told_[n]) continue;
    told_[n] = true;
    const Point2 at = controller_.ends()[n].at;
    what = "the line goes on beyond its end at (" + std::to_string(at.x_mm) + ", " + std::to_string(at.y_mm) +
           ") mm: the shutter stays open";
  }
  return layer == told_layer_ ? std::string() : what;
}

std::vector<control::SeenLine> LineControllerNode::seen_lines() const {
  const double mm = changes_.experiment().aerosol.camera_um_per_px / kUmPerMm;
  std::vector<control::SeenLine> seen;
  for (const vision::LinePictureReading& l : looks_)
    seen.push_back(l.seen && newest_layer_ == looked_layer_
                       ? control::SeenLine{std::abs(l.contrast), l.width_px * mm, l.width_std_px * mm}
                       : control::SeenLine{kNone, kNone, kNone});
  return seen;
}

std::string LineControllerNode::missing_growth(std::int32_t layer, const control::GrowthShare& grown,
                                               Outbox& out) {
  if (layer <= 1 || layer == cut_layer_ || layer == told_layer_) return {};
  if (!grown.resolved()) {
    if (!std::exchange(doubt_told_, true))
      out.warn("the pictures of layer " + std::to_string(layer) +
               " do not tell whether it added ink: a shutter that stays closed is found layers later");
    return {};
  }
  if (grown.share >= changes_.experiment().process.least_rise_share) return {};
  return "the lines of layer " + std::to_string(layer) + " hold " + std::to_string(grown.share) +
         " of the ink that was planned, as they grow in the pictures: the shutter stays closed or "
         "the nozzle is clogged";
}

std::vector<double> LineControllerNode::planned_sections(const control::LineDecision& d) const {
  const AerosolLabConfig& c = changes_.experiment().aerosol;
  std::vector<double> sections;
  for (const double speed_mm_s : d.speed_mm_s)
    sections.push_back(c.flow_mm3_s * c.solids * d.flow_share / speed_mm_s);
  return sections;
}

// The width of the picture stands for the section that looks so wide, where the width is steered.
void LineControllerNode::add_looks(line_plan_t& plan, std::vector<LineReading>& total) const {
  const AerosolLabConfig& c = changes_.experiment().aerosol;
  const double mm = c.camera_um_per_px / kUmPerMm;
  const bool steers = c.width_by == control::WidthActuator::kSpeed;
  const control::VisibleWidth visible(width_mm_ / control::kWidthPerSigma, c.optical_depth_mm);
  plan.looks = std::int32_t(looks_.size());
  for (std::size_t s = 0; s < looks_.size(); ++s) {
    const vision::LinePictureReading& l = looks_[s];
    double gap_px = 0.0;
    for (const vision::LineGap& g : l.gaps) gap_px += g.to_px - g.from_px;
    const bool seen = l.seen && plan.layer - 1 == looked_layer_;
    plan.seen_width_mm.push_back(float(seen ? l.width_px * mm : kNone));
    plan.seen_width_std_mm.push_back(float(seen ? l.width_std_px * mm : kNone));
    plan.seen_offset_mm.push_back(float(seen ? 0.5 * (l.left_px + l.right_px) * mm : kNone));
    plan.seen_overspray.push_back(float(seen ? std::clamp(l.overspray, -1.0, 1.0) : kNone));
    plan.seen_gap_mm.push_back(float(seen ? gap_px * mm : kNone));
    if (steers) total[s].area_mm2 = seen ? visible.section_mm2(l.width_px * mm) : kNone;
  }
}

// The section that a line of the nominal width and of this height has, where the height is held.
void LineControllerNode::hold_height(control::LineMeasurement& m) const {
  const int layers = changes_.experiment().aerosol.layers;
  for (std::size_t s = 0; s < nominal_.size(); ++s) {
    const double per_height = controller_.nominal_area_mm2(s) * layers / nominal_[s].height_mm;
    m.total[s].area_mm2 = m.total[s].height_mm * per_height;
    m.last[s].area_mm2 = m.last[s].height_mm * per_height;
  }
}

double LineControllerNode::squared_width(const control::LineMeasurement& m, const line_plan_t& plan) const {
  const AerosolLabConfig& c = changes_.experiment().aerosol;
  const control::VisibleWidth visible(width_mm_ / control::kWidthPerSigma, c.optical_depth_mm);
  double sum = 0.0, seen = 0.0;
  for (std::size_t s = 0; s < nominal_.size(); ++s) {
    const double share = plan.looks > 0 ? double(plan.seen_width_mm[s]) /
                                              visible.width_mm(m.layer * controller_.nominal_area_mm2(s))
                                        : m.total[s].width_mm / nominal_[s].width_mm;
    if (std::isnan(share)) continue;
    sum += share * share;
    seen += 1.0;
  }
  return seen > 0.0 ? sum / seen : kNone;
}

control::LineMeasurement LineControllerNode::unread(std::int32_t layer, std::int32_t attempt) const {
  control::LineMeasurement m;
  m.layer = layer;
  m.attempt = attempt;
  m.start_error_mm = m.end_error_mm = kNone;
  m.total = m.last = std::vector<LineReading>(controller_.stations().size(), kUnread);
  return m;
}

void LineControllerNode::tell_lines(const control::LineMeasurement& m, line_plan_t& plan) const {
  plan.start_error_mm = m.start_error_mm;
  plan.end_error_mm = m.end_error_mm;
  for (std::size_t s = 0; s < controller_.stations().size(); ++s) {
    const LineReading& total = m.total[s];
    plan.station_x_mm.push_back(float(controller_.stations()[s].at.x_mm));
    plan.station_y_mm.push_back(float(controller_.stations()[s].at.y_mm));
    plan.area_mm2.push_back(float(total.area_mm2));
    plan.layer_area_mm2.push_back(float(m.last[s].area_mm2));
    plan.width_mm.push_back(float(total.width_mm));
    plan.offset_mm.push_back(float(total.offset_mm));
    plan.overspray.push_back(float(std::clamp(total.overspray, -1.0, 1.0)));
  }
}

control::LineDecision LineControllerNode::decide_by_pictures(line_plan_t& plan, Outbox& out) {
  control::LineMeasurement measured = unread(plan.layer - 1, plan.attempt);
  if (measured.layer > 0) {
    const auto error_mm = [&](std::size_t n) { return end_error_mm(n, measured.layer); };
    measured.start_error_mm = mean_over_ends(controller_.ends(), true, error_mm);
    measured.end_error_mm = mean_over_ends(controller_.ends(), false, error_mm);
  }
  tell_lines(measured, plan);
  add_looks(plan, measured.total);
  if (measured.layer != newest_layer_) seen_before_ = std::move(seen_);
  newest_layer_ = measured.layer;
  seen_ = measured.total;
  if (seen_before_.size() == seen_.size())
    for (std::size_t s = 0; s < seen_.size(); ++s)
      measured.last[s].area_mm2 = seen_[s].area_mm2 - (measured.layer > 1 ? seen_before_[s].area_mm2 : 0.0);
  const control::GrowthShare grown =
      measured.layer > 0 ? growth_.look(measured.layer, seen_lines()) : control::GrowthShare();
  if (measured.layer > 1 && !grown.resolved())
    for (LineReading& last : measured.last) last.area_mm2 = kNone;  // noise says nothing of the flow
  if (changes_.experiment().aerosol.width_by == control::WidthActuator::kGas && measured.layer > 0)
    measured.squared_width = squared_width(measured, plan);
  control::LineDecision d = controller_.decide(measured);
  std::string reason = missing_growth(measured.layer, grown, out);
  if (std::string open = new_end_that_goes_on(measured.layer); !open.empty()) reason = std::move(open);
  if (d.kind == PlanDecision::kPrint) {
    planned_.resize(std::size_t(plan.layer));
    planned_.back() = planned_sections(d);
  }
  growth_.plan(plan.layer, planned_sections(d));
  if (!reason.empty()) {
    told_layer_ = measured.layer;
    d = {};
    d.kind = PlanDecision::kStop;
    d.reason = std::move(reason);
  }
  return d;
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

  const AerosolLabConfig& c = changes_.experiment().aerosol;
  vision::LineWindow look;
  look.noise_mm = m.noise_std_mm;
  control::LineMeasurement measured = unread(m.layer, m.attempt);
  if (m.layer > 0) {
    measured.total = read_lines(less(newest_, bare_), controller_.stations(), look);
    const HeightMap last = less(newest_, before_);
    measured.last = read_lines(last, controller_.stations(), look);
    std::vector<double> errors_mm;
    for (const LineEnd& end : controller_.ends())
      errors_mm.push_back(vision::measure_end(last, end, width_mm_, look).value_or(kNone));
    const auto error_mm = [&](std::size_t n) { return errors_mm[n]; };
    measured.start_error_mm = mean_over_ends(controller_.ends(), true, error_mm);
    measured.end_error_mm = mean_over_ends(controller_.ends(), false, error_mm);
  }
  tell_lines(measured, plan);
  if (c.hold == control::HeldQuantity::kHeight && m.layer > 0) hold_height(measured);
  add_looks(plan, measured.total);
  if (c.width_by == control::WidthActuator::kGas && m.layer > 0)
    measured.squared_width = squared_width(measured, plan);
  return controller_.decide(measured);
}

void LineControllerNode::on(const height_map_t& m, Time, Outbox& out) {
  line_plan_t plan{};
  plan.layer = m.layer + 1;
  plan.attempt = m.attempt;
  plan.map_id = m.map_id;
  answer(
      std::move(plan), [&](line_plan_t& p) { return decide(m, p); }, out);
}

void LineControllerNode::answer(line_plan_t plan,
                                const std::function<control::LineDecision(line_plan_t&)>& decide,
                                Outbox& out) {
  plan.flow_share = 1.0;
  plan.start_error_mm = plan.end_error_mm = kNone;
  control::LineDecision d;
  try {
    d = decide(plan);
  } catch (const std::exception& error) {
    d = {};
    d.kind = PlanDecision::kStop;
    d.reason = error.what();
    out.report(Severity::kStop, error.what());
  }
  plan.decision = std::int8_t(d.kind);
  plan.reason = d.reason;
  if (d.kind == PlanDecision::kPrint) {
    plan.path = ++paths_;
    if (!d.reason.empty()) out.warn(d.reason);
  }
  plan.duration_s = d.duration_s;
  plan.open_s = d.open_s;
  plan.printed_mm = d.printed_mm;
  plan.open_delay_s = d.open_delay_s;
  plan.close_delay_s = d.close_delay_s;
  plan.flow_share = d.flow_share;
  plan.sheath_share = d.sheath_share;
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

void LineControllerNode::on(const path_report_t& m, Time, Outbox&) {
  if (Outcome(m.outcome) != Outcome::kDone) cut_layer_ = m.layer;
}

void LineControllerNode::on(const operator_command_t& m, Time, Outbox&) {
  if (OperatorVerb(m.verb) != OperatorVerb::kSet || !changes_.take(m.command_id)) return;
  if (changes_.set(m.key, m.value).empty())
    controller_.use_options(changes_.experiment().aerosol, changes_.experiment().control.smf);
}

}  // namespace firn
