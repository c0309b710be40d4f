#include "core/control/surface/surface_controller_base.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/options/require.h"

namespace firn::control {
namespace {

constexpr int kBeyond_cells = 2;

constexpr std::string_view kWhere = "surface control";

void require(bool ok, const char* name, double value, const char* limit) {
  firn::require(ok, kWhere, std::string(name) + " = " + std::to_string(value) + " must be " + limit);
}

// Cells next to known ones take the mean of their known neighbours, ring by ring; the rest is 0.
void extend(HeightMap& u) {
  const GridSpec& g = u.spec;
  std::vector<std::pair<std::size_t, double>> found;
  for (int ring = 0; ring < kBeyond_cells; ++ring) {
    found.clear();
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        if (std::isfinite(u.at(i, j))) continue;
        double sum = 0.0, n = 0.0;
        for (int y = std::max(j - 1, 0); y <= std::min(j + 1, g.ny - 1); ++y)
          for (int x = std::max(i - 1, 0); x <= std::min(i + 1, g.nx - 1); ++x)
            if (std::isfinite(u.at(x, y))) {
              sum += u.at(x, y);
              n += 1.0;
            }
        if (n > 0.0) found.emplace_back(g.index(i, j), sum / n);
      }
    for (const auto& [cell, value] : found) u.cells[cell] = value;
  }
  for (double& v : u.cells)
    if (!std::isfinite(v)) v = 0.0;
}

}  // namespace

void check(const SurfaceOptions& o) {
  require(std::isfinite(o.interval_mm) && o.interval_mm > 0.0, "interval_mm", o.interval_mm, "above 0");
  require(std::isfinite(o.target_offset_mm), "target_offset_mm", o.target_offset_mm, "finite");
  check_options(kWhere, kSurfaceOptions, o);
  check_options(kWhere, kSmfGains, o.smf);
  check_options(kWhere, kSurfaceForeseeOptions, o.foresee, "foresee.");
  const SurfaceAdaptiveOptions& a = o.adaptive;
  require(std::isfinite(a.kp) && a.kp > 0.0, "adaptive.kp", a.kp, "above 0");
  require(a.gain_min > 0.0 && a.gain_min <= a.gain, "adaptive.gain_min", a.gain_min,
          "above 0 and at most adaptive.gain");
  require(a.gain_max >= a.gain && a.gain_max <= 1.0, "adaptive.gain_max", a.gain_max,
          "at least adaptive.gain and at most 1");
  require(a.gain_rate >= 0.0 && a.gain_rate <= 1.0, "adaptive.gain_rate", a.gain_rate, "between 0 and 1");
  require(a.window_cells >= 0 && a.window_cells <= 100, "adaptive.window_cells", a.window_cells,
          "between 0 and 100");
}

void check(const SurfaceMeasurement& m, int last_layer_seen) {
  firn::check(m.height.spec);
  if (m.material.spec != m.height.spec || m.height.size() != m.height.spec.size() ||
      m.material.size() != m.height.size())
    throw std::invalid_argument("height map: the footprint is not on the same grid");
  if (!std::isfinite(m.nominal_mm))
    throw std::invalid_argument("height map: the nominal height is not finite");
  if (m.layer < 0 || m.attempt < 0 || m.layer < last_layer_seen)
    throw std::invalid_argument("height map: layer " + std::to_string(m.layer) + " after layer " +
                                std::to_string(last_layer_seen));
  bool any = false;
  for (std::size_t c = 0; c < m.height.size(); ++c) {
    if (!m.material.cells[c]) continue;
    any = true;
    if (!std::isfinite(m.height.cells[c]))
      throw std::invalid_argument("height map: cell (" + std::to_string(c % std::size_t(m.height.spec.nx)) +
                                  ", " + std::to_string(c / std::size_t(m.height.spec.nx)) +
                                  ") of the part has no finite height");
  }
  if (!any) throw std::invalid_argument("height map: layer " + std::to_string(m.layer) + " has no footprint");
}

ActionBounds action_bounds(const SurfaceOptions& o) {
  if (o.version == SurfaceVersion::kValveFrequency) return {-o.output_limit, o.output_limit};
  return {1.0 / (1.0 + o.speed_range) - 1.0, 1.0 / (1.0 - o.speed_range) - 1.0};
}

HeightMap on_footprint(const HeightMap& values, const Grid<std::uint8_t>& material) {
  HeightMap out = values;
  for (std::size_t c = 0; c < out.size(); ++c)
    if (!material.cells[c]) out.cells[c] = kNotMeasured;
  return out;
}

HeightMap carried_over(const HeightMap& from, const GridSpec& to) {
  if (from.size() == 0) return HeightMap(to, 0.0);
  HeightMap out = resample(from, to, 0.0);
  for (double& v : out.cells)
    if (!std::isfinite(v)) v = 0.0;
  return out;
}

HeightMap error_surface(const SurfaceMeasurement& m, double interval_mm) {
  HeightMap e(m.height.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c)
    if (m.material.cells[c]) e.cells[c] = (m.nominal_mm - m.height.cells[c]) / interval_mm;
  return e;
}

SurfaceControllerBase::SurfaceControllerBase(const SurfaceOptions& options) : options_(options) {
  check(options);
}

void SurfaceControllerBase::use_options(const SurfaceOptions& options) {
  check(options);
  take_changeable(kSurfaceOptions, options, options_);
  take_changeable(kSmfGains, options.smf, options_.smf);
  take_changeable(kSurfaceForeseeOptions, options.foresee, options_.foresee);
  options_.target_offset_mm = options.target_offset_mm;
}

void SurfaceControllerBase::use_flow(const std::array<double, 2>& factor) {
  for (const double f : factor)
    if (!(std::isfinite(f) && f > 0.0))
      throw std::invalid_argument("flow factor " + std::to_string(f) + " must be above 0");
  if (options_.feed_forward) factor_ = factor;
}

SurfaceDecision SurfaceControllerBase::decide(const SurfaceMeasurement& m) {
  check(m, layer_);
  const bool again = m.layer == layer_;
  layer_ = m.layer;
  if (!again) before_ = after_;
  const HeightMap error = error_surface(m, options_.interval_mm);
  const ActionBounds bounds = action_bounds(options_);

  SurfaceDecision d;
  d.u = control_law(m, error, again);
  HeightMap executed_u = d.u;
  double cells = 0.0, squares = 0.0, sum = 0.0, saturated = 0.0;
  std::array<double, 2> of_material{}, wants_all{};
  for (std::size_t c = 0; c < error.size(); ++c) {
    if (!m.material.cells[c]) continue;
    const std::size_t material = m.material.cells[c] == std::uint8_t(CellMaterial::kScaffold) ? 1 : 0;
    const double off_mm = m.height.cells[c] - m.nominal_mm;
    cells += 1.0;
    of_material[material] += 1.0;
    squares += off_mm * off_mm;
    sum += off_mm;
    const double wanted = (1.0 + d.u.cells[c]) / factor_[material] - 1.0;
    const double u = std::clamp(wanted, bounds.low, bounds.high);  // saturation planes (5.2.2)
    if (u != wanted) saturated += 1.0;
    if (wanted >= bounds.high) wants_all[material] += 1.0;
    d.u.cells[c] = u;
    executed_u.cells[c] = factor_[material] * (1.0 + u) - 1.0;
  }
  executed(executed_u);
  extend(d.u);
  d.saturated_fraction = saturated / cells;
  d.rms_mm = std::sqrt(squares / cells);
  d.mean_error_mm = sum / cells;
  d.feed_forward = {1.0 / factor_[0], 1.0 / factor_[1]};
  const auto counted = [&](int before, std::size_t material) {
    return of_material[material] > 0.0
               ? (wants_all[material] > options_.stop_share * of_material[material] ? before + 1 : 0)
               : before;
  };
  after_ = {counted(before_.part, 0), counted(before_.scaffold, 1)};

  d.kind = SurfaceDecision::Kind::kPrint;
  d.reason = "layer " + std::to_string(m.layer) + ": action of scheme " + options_.scheme;
  if (options_.last_layer > 0 && m.layer >= options_.last_layer) {
    d.kind = SurfaceDecision::Kind::kEnd;
    d.reason = "the last layer is printed";
  } else if (options_.stop_after > 0 && std::max(after_.part, after_.scaffold) >= options_.stop_after) {
    d.kind = SurfaceDecision::Kind::kStop;
    d.reason = std::string(after_.part >= after_.scaffold ? "the part" : "the scaffold") +
               " asks for all the material there is for " +
               std::to_string(std::max(after_.part, after_.scaffold)) +
               " height maps running: tank empty, line blocked, or a part that cannot be built";
  }
  return d;
}

}  // namespace firn::control
