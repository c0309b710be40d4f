#include "core/path/trajectory_codec.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace firn {
namespace {

static_assert(std::endian::native == std::endian::little, "trajectories are written little endian");

constexpr std::size_t kMaxAxes = 8, kMaxLimits = 64, kMaxText = 200, kMaxSamples = std::size_t(1) << 24;

class Out {
 public:
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  /// Every stride-th of n numbers.
  void put_numbers(const double* from, std::size_t n, std::size_t stride) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + n * sizeof(double));
    std::byte* to = bytes_.data() + at;
    for (std::size_t i = 0; i < n; ++i) std::memcpy(to + i * sizeof(double), from + i * stride, sizeof(double));
  }
  template <class T>
  void put(T value) {
    const auto* p = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), p, p + sizeof value);
  }
  void put_text(const std::string& text) {
    const std::size_t n = std::min(text.size(), kMaxText);
    put(std::uint16_t(n));
    const auto* p = reinterpret_cast<const std::byte*>(text.data());
    bytes_.insert(bytes_.end(), p, p + n);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class In {
 public:
  explicit In(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[noreturn]] void fail(const std::string& problem) const { throw TrajectoryFormatError(at_, problem); }

  template <class T>
  T get(const char* what) {
    if (bytes_.size() - at_ < sizeof(T)) fail(std::string("ends before ") + what);
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  double get_number(const char* what, double low = -1e12, double high = 1e12) {
    const double value = get<double>(what);
    if (!(value >= low && value <= high)) {
      at_ -= sizeof value;
      fail(std::string(what) + " is not a number between " + std::to_string(low) + " and " + std::to_string(high));
    }
    return value;
  }
  std::size_t get_count(const char* what, std::size_t limit) {
    const std::size_t n = get<std::uint32_t>(what);
    if (n <= limit) return n;
    at_ -= sizeof(std::uint32_t);
    fail(std::string(what) + " = " + std::to_string(n) + " is above the limit of " + std::to_string(limit));
  }
  std::string get_text(const char* what) {
    const std::size_t n = get<std::uint16_t>(what);
    if (n > kMaxText) fail(std::string(what) + " is longer than the limit of " + std::to_string(kMaxText) + " bytes");
    if (bytes_.size() - at_ < n) fail(std::string("ends within ") + what);
    std::string text(reinterpret_cast<const char*>(bytes_.data() + at_), n);
    at_ += n;
    return text;
  }
  void need(std::size_t bytes, const char* what) const {
    if (bytes_.size() - at_ < bytes) fail(std::string("ends within ") + what);
  }
  void end() const {
    if (at_ != bytes_.size()) fail(std::to_string(bytes_.size() - at_) + " bytes are left over");
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

bool constant(const Trajectory& t, std::size_t axis) {
  for (std::size_t n = axis; n < t.positions.size(); n += std::size_t(t.axes))
    if (std::memcmp(&t.positions[n], &t.positions[axis], sizeof(double)) != 0) return false;
  return !t.positions.empty();
}

}  // namespace

std::vector<std::byte> encode(const TrajectoryHead& h) {
  Out out;
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
  In in(bytes);
  TrajectoryHead h;
  if (const auto version = in.get<std::uint32_t>("version"); version != kTrajectoryVersion)
    in.fail("version " + std::to_string(version) + " is unknown; this program reads version " + std::to_string(kTrajectoryVersion));
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
    if (h.axis_units.back() != "rad" && h.axis_units.back() != "mm") in.fail("the unit of an axis is neither rad nor mm");
  }
  in.end();
  return h;
}

std::vector<std::byte> encode(const PlannedPath& p) {
  const Trajectory& t = p.trajectory;
  if (t.axes < 1 || t.positions.size() % std::size_t(t.axes) != 0)
    throw std::invalid_argument("positions are not whole samples of " + std::to_string(t.axes) + " axes");
  const std::size_t axes = std::size_t(t.axes);
  Out out;
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
    out.put_numbers(t.positions.data() + a, still ? 1 : t.samples(), axes);
  }
  return out.take();
}

PlannedPath decode_trajectory(std::span<const std::byte> bytes, const TrajectoryHead& head) {
  In in(bytes);
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
    for (std::size_t n = 0; n < samples; ++n) t.positions[n * axes + a] = still ? first : in.get_number("position");
  }
  in.end();
  return p;
}

std::vector<std::byte> encode(const TrajectoryTotals& t) {
  Out out;
  out.put(t.paths);
  out.put(t.samples);
  out.put(t.duration_s);
  return out.take();
}

TrajectoryTotals decode_trajectory_totals(std::span<const std::byte> bytes) {
  In in(bytes);
  TrajectoryTotals t;
  t.paths = in.get<std::int64_t>("number of paths");
  t.samples = in.get<std::int64_t>("number of samples");
  t.duration_s = in.get_number("duration", 0.0);
  in.end();
  return t;
}

}  // namespace firn
