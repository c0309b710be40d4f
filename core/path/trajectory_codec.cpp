#include "core/path/trajectory_codec.h"

#include <cstring>

namespace firn {
namespace {

constexpr std::size_t kMaxAxes = 8, kMaxLimits = 64, kMaxSamples = std::size_t(1) << 24;

bool constant(const Trajectory& t, std::size_t axis) {
  for (std::size_t n = axis; n < t.positions.size(); n += std::size_t(t.axes))
    if (std::memcmp(&t.positions[n], &t.positions[axis], sizeof(double)) != 0) return false;
  return !t.positions.empty();
}

}  // namespace

std::vector<std::byte> encode(const TrajectoryHead& h) {
  ByteWriter out;
  out.put(kTrajectoryVersion);
  out.put(h.tick_s);
  out.put(h.origin.x_mm);
  out.put(h.origin.y_mm);
  out.put_text(h.machine);
  out.put_text(h.method);
  out.put_text(h.made_by);
  out.put(std::uint32_t(h.axis_names.size()));
  for (std::size_t a = 0; a < h.axis_names.size(); ++a) {
    out.put_text(h.axis_names[a]);
    out.put_text(h.axis_units[a]);
  }
  return out.take();
}

TrajectoryHead decode_trajectory_head(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  TrajectoryHead h;
  if (const auto version = in.get<std::uint32_t>("version"); version != kTrajectoryVersion)
    in.fail("version " + std::to_string(version) + " is unknown; this program reads version " +
            std::to_string(kTrajectoryVersion));
  h.tick_s = in.get_number("tick_s", 1e-9, 1e3);
  h.origin.x_mm = in.get_number("origin x");
  h.origin.y_mm = in.get_number("origin y");
  h.machine = in.get_text("machine");
  h.method = in.get_text("method");
  h.made_by = in.get_text("made_by");
  const std::size_t axes = in.get_count("number of axes", kMaxAxes);
  for (std::size_t a = 0; a < axes; ++a) {
    h.axis_names.push_back(in.get_text("axis name"));
    h.axis_units.push_back(in.get_text("axis unit"));
    if (h.axis_units.back() != "rad" && h.axis_units.back() != "mm")
      in.fail("the unit of an axis is neither rad nor mm");
  }
  in.end();
  return h;
}

std::vector<std::byte> encode(const PlannedPath& p) {
  const Trajectory& t = p.trajectory;
  if (t.axes < 1 || t.positions.size() % std::size_t(t.axes) != 0)
    throw std::invalid_argument("positions are not whole samples of " + std::to_string(t.axes) + " axes");
  const std::size_t axes = std::size_t(t.axes);
  ByteWriter out;
  out.reserve(1000 + t.positions.size() * sizeof(double));
  out.put(t.id);
  out.put(p.layer);
  out.put(p.material);
  out.put(std::uint8_t(p.kind));
  out.put(std::uint16_t(axes));
  out.put(p.path_mm);
  out.put(t.certificate.duration_s);
  out.put(t.certificate.lower_bound_s);
  out.put(t.certificate.curvature_ramp_mm);
  out.put(std::uint32_t(t.certificate.limits.size()));
  for (const LimitRatio& l : t.certificate.limits) {
    out.put_text(l.limit);
    out.put(l.ratio);
    out.put(l.time_s);
  }
  out.put(std::uint32_t(t.samples()));
  for (std::size_t a = 0; a < axes; ++a) {
    const bool still = constant(t, a);
    out.put(std::uint8_t(still));
    if (!t.positions.empty()) out.put_numbers(&t.positions[a], still ? 1 : t.samples(), axes);
  }
  return out.take();
}

PlannedPath decode_trajectory(std::span<const std::byte> bytes, const TrajectoryHead& head) {
  ByteReader in(bytes);
  PlannedPath p;
  Trajectory& t = p.trajectory;
  t.id = in.get<std::int64_t>("id");
  p.layer = in.get<std::int32_t>("layer");
  p.material = in.get<std::uint8_t>("material");
  const auto kind = in.get<std::uint8_t>("kind");
  if (kind > std::uint8_t(PathKind::kMeasurement)) in.fail("kind " + std::to_string(kind) + " is unknown");
  p.kind = PathKind(kind);
  const std::size_t axes = in.get<std::uint16_t>("axes");
  if (axes != head.axis_names.size())
    in.fail(std::to_string(axes) + " axes, but the file has " + std::to_string(head.axis_names.size()));
  p.path_mm = in.get_number("path length", 0.0);
  t.certificate.duration_s = in.get_number("duration", 0.0);
  t.certificate.lower_bound_s = in.get_number("lower bound", 0.0);
  t.certificate.curvature_ramp_mm = in.get_number("curvature ramp", 0.0);
  const std::size_t limits = in.get_count("number of limits", kMaxLimits);
  for (std::size_t n = 0; n < limits; ++n) {
    LimitRatio l;
    l.limit = in.get_text("limit name");
    l.ratio = in.get_number("ratio", 0.0);
    l.time_s = in.get_number("time of the ratio", 0.0);
    t.certificate.limits.push_back(std::move(l));
  }
  const std::size_t samples = in.get_count("number of samples", kMaxSamples);
  t.axes = std::int32_t(axes);
  t.tick_s = head.tick_s;
  t.axis_units = head.axis_units;
  in.need(axes * (1 + (samples > 0 ? sizeof(double) : 0)), "the positions");
  if (axes == 0) in.fail("a trajectory without axes");
  for (std::size_t a = 0; a < axes; ++a) {
    const auto still = in.get<std::uint8_t>("axis mark");
    if (still > 1) in.fail("axis mark " + std::to_string(still) + " is unknown");
    if (!still) in.need(samples * sizeof(double), "the positions");
    if (t.positions.empty()) {
      if (still && samples > bytes.size()) in.fail("more samples than a file of this size can mean");
      t.positions.resize(axes * samples);
    }
    const double first = still && samples > 0 ? in.get_number("position") : 0.0;
    for (std::size_t n = 0; n < samples; ++n)
      t.positions[n * axes + a] = still ? first : in.get_number("position");
  }
  in.end();
  return p;
}

std::vector<std::byte> encode(const TrajectoryTotals& t) {
  ByteWriter out;
  out.put(t.paths);
  out.put(t.samples);
  out.put(t.duration_s);
  return out.take();
}

TrajectoryTotals decode_trajectory_totals(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  TrajectoryTotals t;
  t.paths = in.get<std::int64_t>("number of paths");
  t.samples = in.get<std::int64_t>("number of samples");
  t.duration_s = in.get_number("duration", 0.0);
  in.end();
  return t;
}

}  // namespace firn
