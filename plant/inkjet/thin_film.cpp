// The film nature: wet ink on cured ground flows by lubrication theory (plant/film/film_flow.h) until the
// lamp gels it.
//
// Droplets land as paraboloids. Contact lines are pinned where they are until their apparent angle exceeds
// the advancing one; at an edge the ground's own fall is added to it [Gibbs], and a line climbs no step that
// is higher than the liquid. Beside a step steeper than most_slope nothing flows: both sides have a line of
// their own there, as at the rim of a part. Gravity is left out: the Bond number of a droplet is 0.015.
//
// Under the lamp the conversion rises evenly up to the gel after gel_s, and the viscosity as
// (1 - conversion / conversion at the gel)^-b. One dose cures the whole film, so that the viscosity is even,
// and the flow until the gel is that of uncured ink in the time  integral of (1 - t / gel_s)^b = gel_s / (b +
// 1).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "plant/film/film_flow.h"
#include "plant/inkjet/droplet_source.h"
#include "plant/inkjet/model.h"

namespace firn::plant {
namespace {

constexpr double kSecond_us = 1e6, kMmPerM = 1e3;
constexpr double kFirstChunk_s = 0.02;  ///< of flow between looks at the contact lines; doubles
constexpr double kGift = 0.1;           ///< at most this part of a cell's film goes into a precursor

/// A droplet that has landed and is not in the film yet.
struct WaitingDroplet {
  double volume_mm3, x_mm, y_mm;
};

class ThinFilm final : public Model {
 public:
  explicit ThinFilm(const WorldConfig& c)
      : options_(c.nature.thin_film),
        grid_(c.grid),
        shrink_(c.droplet.cure_shrink),
        source_(c),
        field_(c.grid, options_.fine_cells, options_.margin_cells),
        film_({field_.width(), field_.height(), field_.dx_mm(), field_.dy_mm()},
              {kMmPerM * options_.surface_tension_N_m / (3.0 * options_.viscosity_Pa_s), 0.0,
               MobilityPower::kThree, true}) {
    std::fill(film_.wet().begin(), film_.wet().end(), std::uint8_t{0});
    film_.faces_changed(options_.most_slope);
  }

  Landing fire(const Shot& shot) override {
    const Landing out = source_.fire(shot, layers_.layer(), true);
    if (out.missed) return out;
    ledger_.landed += out.volume_mm3;
    if (waiting_.empty()) {
      begun_us_ = shot.t_us;
    } else if (double(shot.t_us - begun_us_) > options_.group_s * kSecond_us) {
      let_flow();
      begun_us_ = shot.t_us;
    }
    last_us_ = shot.t_us;
    waiting_.push_back({out.volume_mm3, out.x_mm, out.y_mm});
    return out;
  }
  void end_pass() override { let_flow(); }
  void expose(std::int64_t now_us) override {
    let_flow();
    flow_for(options_.wet_s > 0.0 ? options_.wet_s : std::max(0.0, double(now_us - film_us_) / kSecond_us));
    flow_for(options_.gel_s / (options_.gel_power + 1.0));
    look_at_validity();
    cure();
    film_us_ = now_us;
    if (layers_.exposed()) source_.cured(now_us, layers_.layer() + 1);
  }
  void measured() override {
    if (layers_.measured()) source_.measured();
  }

  const Field& surface() override {
    let_flow();
    show(field_);
    return field_;
  }
  HeightMap cell_means() const override { return shown().cell_means(); }
  HeightMap means_with_margin() const override { return shown().means_with_margin(); }
  HeightMap fine_surface() const override { return shown().fine_surface(); }
  VolumeLedger ledger() const override { return ledger_; }
  double volume_mm3() const override {
    double sum = 0.0;
    for (std::size_t n = 0; n < film_.height().size(); ++n) sum += film_.height()[n] + film_.ground()[n];
    double volume = sum * cell_mm2();
    for (const WaitingDroplet& w : waiting_) volume += w.volume_mm3;
    return volume;
  }
  const LayerCount& layers() const override { return layers_; }
  std::vector<Validity> validity() const override {
    return {{"slope of the wet surface", reached_slope_, options_.most_slope},
            {"wave number of the pitch times film thickness", reached_depth_, options_.most_depth}};
  }
  MaterialColumns materials() const override { return {}; }
  void io(Archive& a) override {
    a.all(source_, film_.height(), film_.ground(), film_.wet(), waiting_, begun_us_, last_us_, film_us_,
          layers_, ledger_, reached_slope_, reached_depth_);
    if (a.loading()) film_.faces_changed(options_.most_slope);
  }

 private:
  double cell_mm2() const { return film_.grid().dx * film_.grid().dy; }
  bool any_wet() const { return std::ranges::find(film_.wet(), std::uint8_t{1}) != film_.wet().end(); }

  /// Puts the waiting droplets into the film, which flows until then.
  void let_flow() {
    if (waiting_.empty()) return;
    flow_for(std::max(0.0, double(begun_us_ - film_us_) / kSecond_us));
    for (const WaitingDroplet& w : waiting_) land(w);
    waiting_.clear();
    film_us_ = last_us_;
    film_.faces_changed(options_.most_slope);
  }
  void land(const WaitingDroplet& w);
  void flow_for(double seconds);
  bool advance_lines();
  void look_at_validity();
  void cure();
  void show(Field& field) const;
  Field shown() const {
    Field field = field_;
    show(field);
    return field;
  }

  ThinFilmOptions options_;
  GridSpec grid_;
  double shrink_;
  DropletSource source_;
  Field field_;  ///< the surface as the sensor's input
  FilmFlow film_;
  std::vector<WaitingDroplet> waiting_;
  std::int64_t begun_us_ = 0, last_us_ = 0;  ///< landing of the first and the last waiting droplet
  std::int64_t film_us_ = 0;                 ///< time of the film
  LayerCount layers_;
  VolumeLedger ledger_;
  double reached_slope_ = 0.0, reached_depth_ = 0.0;
};

void ThinFilm::land(const WaitingDroplet& w) {
  const FilmGrid& g = film_.grid();
  const double r = options_.radius_mm;
  const double u = w.x_mm - field_.left_mm(), v = w.y_mm - field_.bottom_mm();  // of the middle
  if (!(u >= r && v >= r && u + r <= g.nx * g.dx && v + r <= g.ny * g.dy)) {    // true for NaN as well
    ledger_.lost += w.volume_mm3;
    return;
  }
  // Each cell's share of a paraboloid, from 2 x 2 Gauss points.
  const double point = 0.5 / std::numbers::sqrt3;
  const int a0 = std::max(0, int((u - r) / g.dx)), a1 = std::min(g.nx - 1, int((u + r) / g.dx)),
            b0 = std::max(0, int((v - r) / g.dy)), b1 = std::min(g.ny - 1, int((v + r) / g.dy));
  const auto weight = [&](int a, int b) {
    double sum = 0.0;
    for (const double y : {-point, point})
      for (const double x : {-point, point}) {
        const double dx = (a + 0.5 + x) * g.dx - u, dy = (b + 0.5 + y) * g.dy - v;
        sum += std::max(0.0, 1.0 - (dx * dx + dy * dy) / (r * r));
      }
    return sum;
  };
  double whole = 0.0;
  for (int b = b0; b <= b1; ++b)
    for (int a = a0; a <= a1; ++a) whole += weight(a, b);
  for (int b = b0; b <= b1; ++b)
    for (int a = a0; a <= a1; ++a) {
      const double share = weight(a, b) / whole;
      if (!(share > 0.0)) continue;
      const std::size_t n = std::size_t(b) * std::size_t(g.nx) + std::size_t(a);
      film_.height()[n] += share * w.volume_mm3 / cell_mm2();
      film_.wet()[n] = 1;
    }
}

void ThinFilm::flow_for(double seconds) {
  if (!any_wet()) return;
  double chunk_s = kFirstChunk_s;
  for (double left_s = seconds; left_s > 0.0;) {
    const double now_s = std::min(chunk_s, left_s);
    film_.flow(now_s);
    left_s -= now_s;
    if (!advance_lines()) chunk_s *= 2.0;
  }
}

/// Wets cells beside contact lines whose angle exceeds the advancing one; returns whether there were any.
bool ThinFilm::advance_lines() {
  const FilmGrid& g = film_.grid();
  const std::vector<double>& ground = film_.ground();
  std::vector<double>& h = film_.height();
  std::vector<std::uint8_t>& wet = film_.wet();
  const double advancing = std::tan(options_.advancing_deg * std::numbers::pi / 180.0);
  struct Advance {
    std::size_t from, to;
  };
  std::vector<Advance> advances;
  const auto look = [&](std::size_t n, std::size_t m, double d) {
    if (wet[m]) return;
    const double step_mm = ground[m] - ground[n];
    if (std::abs(step_mm) > options_.most_slope * d || step_mm > h[n]) return;
    if (2.0 * h[n] / d > advancing + std::max(0.0, -step_mm / d)) advances.push_back({n, m});
  };
  const auto row = std::size_t(g.nx);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t n = std::size_t(j) * row + std::size_t(i);
      if (!wet[n]) continue;
      if (i > 0) look(n, n - 1, g.dx);
      if (i + 1 < g.nx) look(n, n + 1, g.dx);
      if (j > 0) look(n, n - row, g.dy);
      if (j + 1 < g.ny) look(n, n + row, g.dy);
    }
  for (const Advance& a : advances) {
    const double gift = std::min(options_.precursor_mm, kGift * h[a.from]);
    h[a.from] -= gift;
    h[a.to] += gift;
    wet[a.to] = 1;
  }
  if (!advances.empty()) film_.faces_changed(options_.most_slope);
  return !advances.empty();
}

void ThinFilm::look_at_validity() {
  const FilmGrid& g = film_.grid();
  const auto row = std::size_t(g.nx);
  const std::vector<double>& h = film_.height();
  double slope = 0.0, depth_mm = 0.0;
  for (std::size_t n = 0; n < h.size(); ++n) {
    if (!film_.wet()[n]) continue;
    const auto look = [&](std::size_t m, double d) {
      if (!film_.wet()[m] || std::abs(film_.ground()[m] - film_.ground()[n]) > options_.most_slope * d)
        return;
      slope = std::max(slope, std::abs(film_.ground()[m] + h[m] - film_.ground()[n] - h[n]) / d);
    };
    if ((n + 1) % row != 0) look(n + 1, g.dx);
    if (n + row < h.size()) look(n + row, g.dy);
  }
  const int fine = options_.fine_cells;
  for (int j = 0; j + fine <= g.ny; j += fine)
    for (int i = 0; i + fine <= g.nx; i += fine) {
      double sum = 0.0;
      for (int b = 0; b < fine; ++b)
        for (int a = 0; a < fine; ++a) sum += h[std::size_t(j + b) * row + std::size_t(i + a)];
      depth_mm = std::max(depth_mm, sum / (fine * fine));
    }
  const double depth = 2.0 * std::numbers::pi / std::min(grid_.pitch_x_mm, grid_.pitch_y_mm) * depth_mm;
  reached_slope_ = std::max(reached_slope_, slope);
  reached_depth_ = std::max(reached_depth_, depth);
  for (const Validity& v : validity())
    if (v.reached > v.most) {
      char text[200];
      std::snprintf(
          text, sizeof text,
          "plant.model = \"thin_film\": %s has reached %.3g, and lubrication theory is used up to %.3g",
          v.quantity.c_str(), v.reached, v.most);
      throw NatureError(text);
    }
}

void ThinFilm::cure() {
  std::vector<double>& h = film_.height();
  for (std::size_t n = 0; n < h.size(); ++n) {
    film_.ground()[n] += (1.0 - shrink_) * h[n];
    ledger_.shrunk += shrink_ * h[n] * cell_mm2();
    h[n] = 0.0;
    film_.wet()[n] = 0;
  }
  film_.faces_changed(options_.most_slope);
}

void ThinFilm::show(Field& field) const {
  const FilmGrid& g = film_.grid();
  for (int b = 0; b < g.ny; ++b)
    for (int a = 0; a < g.nx; ++a) {
      const std::size_t n = std::size_t(b) * std::size_t(g.nx) + std::size_t(a);
      field.set_solid_mm(a, b, film_.ground()[n] + film_.height()[n]);
    }
}

}  // namespace

std::unique_ptr<Model> make_thin_film_model(const WorldConfig& config) {
  return std::make_unique<ThinFilm>(config);
}

}  // namespace firn::plant
