// The independent plant computes droplets as volumes on the fine field, with scatter, misses, satellites and
// drift.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/grid/random.h"
#include "plant/inkjet/ink_stack.h"
#include "plant/inkjet/model.h"
#include "plant/inkjet/nozzle.h"

namespace firn::plant {
namespace {

// The printer's own ink in place of the calibrated one.
DropletParams scaled(DropletParams p) {
  p.volume_mm3 *= p.flow;
  const double wider = p.spread * std::pow(p.flow, p.radius_exponent);
  p.cap_radius_mm *= wider;
  p.film_radius_mm *= wider;
  return p;
}

class DropletModel : public Model {
 public:
  explicit DropletModel(const WorldConfig& c)
      : grid_(c.grid),
        params_(scaled(c.droplet)),
        seed_(c.seed),
        field_(c.grid, params_.fine_cells, params_.margin_cells),
        nozzle_(c.nozzle, c.seed),
        nozzle_b_(c.nozzle, c.seed, 1),
        attempts_(c.grid.size(), 0),
        ratio_b_(c.ratio_b) {
    if (c.two_inks) stack_.emplace(c.grid);
  }

  Landing fire(const Shot& shot) override {
    const NearestCell cell = nearest_cell(grid_, shot.x_mm, shot.y_mm);
    const bool on_grid = grid_.contains(cell.i, cell.j);
    const std::uint32_t attempt = on_grid ? attempts_[grid_.index(cell.i, cell.j)]++ : off_grid_attempts_++;
    const std::uint32_t key = cell_key(cell);
    const auto draw = [&](Purpose purpose, std::uint32_t n) {
      return DrawKey{seed_, purpose, layers_.layer(), 4 * attempt + n, key};
    };
    if (stack_ && shot.ink != wet_ink_) account();
    wet_ink_ = shot.ink;
    const double factor =
        shot.ink == Material::kB ? ratio_b_ * nozzle_b_.fire(shot.t_us) : nozzle_.fire(shot.t_us);
    Landing out;
    out.x_mm = shot.x_mm + shot.vx_mm_s * params_.flight_time_s;
    out.y_mm = shot.y_mm + shot.vy_mm_s * params_.flight_time_s;
    out.missed = cell.j == params_.dead_row ||
                 (params_.missed_probability > 0.0 &&
                  random_uniform(draw(Purpose::kMissedDroplet, 0)) < params_.missed_probability);
    if (out.missed) return out;
    if (params_.placement_scatter_mm > 0.0) {
      out.x_mm += params_.placement_scatter_mm * random_normal(draw(Purpose::kDropletPlacement, 0));
      out.y_mm += params_.placement_scatter_mm * random_normal(draw(Purpose::kDropletPlacement, 1));
    }
    double scatter = 0.0;
    if (params_.size_scatter > 0.0)
      scatter = std::clamp(random_normal(draw(Purpose::kDropletSize, 0)), -4.0, 4.0) * params_.size_scatter;
    out.volume_mm3 = params_.volume_mm3 * shot.volume_share * std::max(0.05, factor + scatter);
    double satellite = 0.0;
    if (params_.satellite_probability > 0.0 &&
        random_uniform(draw(Purpose::kSatellite, 0)) < params_.satellite_probability)
      satellite = params_.satellite_share * out.volume_mm3;
    const DropletParams& shape = shot.volume_share == 1.0 ? params_ : of_share(shot.volume_share);
    field_.land(shape, out.volume_mm3 - satellite, out.x_mm, out.y_mm);
    if (satellite > 0.0) {
      const double angle = 2.0 * std::numbers::pi * random_uniform(draw(Purpose::kSatellite, 1));
      field_.land(shape, satellite, out.x_mm + params_.satellite_distance_mm * std::cos(angle),
                  out.y_mm + params_.satellite_distance_mm * std::sin(angle));
    }
    return out;
  }

  void end_pass() override {}
  void account() { stack_->account(field_.cell_means(), wet_ink_); }
  void expose(std::int64_t now_us) override {
    if (stack_) account();
    field_.cure(params_.cure_shrink);
    if (stack_) stack_->cured(field_.cell_means());
    if (!layers_.exposed()) return;
    nozzle_.cured(now_us, layers_.layer() + 1);
    if (stack_) nozzle_b_.cured(now_us, layers_.layer() + 1);
  }
  void measured() override {
    if (!layers_.measured()) return;
    std::fill(attempts_.begin(), attempts_.end(), 0u);
    off_grid_attempts_ = 0;
  }
  const Field& surface() override { return field_; }
  HeightMap cell_means() const override { return field_.cell_means(); }
  HeightMap means_with_margin() const override { return field_.means_with_margin(); }
  HeightMap fine_surface() const override { return field_.fine_surface(); }
  VolumeLedger ledger() const override { return field_.ledger(); }
  double volume_mm3() const override { return field_.volume_mm3(); }
  const LayerCount& layers() const override { return layers_; }
  MaterialColumns materials() const override { return stack_ ? stack_->columns() : MaterialColumns{}; }
  void io(Archive& a) override {
    a.all(field_, nozzle_, attempts_, off_grid_attempts_, layers_);
    if (stack_) a.all(*stack_, nozzle_b_, wet_ink_);
  }

 private:
  // A droplet of another pulse meets the ground at the same angle: its radii grow with V^(1/3).
  const DropletParams& of_share(double share) {
    if (share != other_share_) {
      other_ = params_;
      other_.cap_radius_mm *= std::cbrt(share);
      other_.film_radius_mm *= std::cbrt(share);
      other_share_ = share;
    }
    return other_;
  }

  GridSpec grid_;
  DropletParams params_;
  DropletParams other_;  ///< of another pulse's droplets, computed anew after a resume
  double other_share_ = 1.0;
  std::uint64_t seed_;
  Field field_;
  Nozzle nozzle_, nozzle_b_;
  std::vector<std::uint32_t> attempts_;  ///< droplets per cell of this layer
  std::uint32_t off_grid_attempts_ = 0;
  LayerCount layers_;
  double ratio_b_;
  Material wet_ink_ = Material::kA;  ///< of the newest droplet
  std::optional<InkStack> stack_;    ///< with two inks
};

}  // namespace

NearestCell nearest_cell(const GridSpec& grid, double x_mm, double y_mm) {
  const auto round = [](double u) {
    return std::int32_t(std::floor(std::clamp(u, -30000.0, 30000.0) + 0.5));
  };
  return {round((x_mm - grid.origin_x_mm) / grid.pitch_x_mm),
          round((y_mm - grid.origin_y_mm) / grid.pitch_y_mm)};
}

std::uint32_t cell_key(NearestCell cell) {
  return std::uint32_t(cell.j & 0xffff) << 16 | std::uint32_t(cell.i & 0xffff);
}

std::unique_ptr<Model> make_droplet_model(const WorldConfig& config) {
  return std::make_unique<DropletModel>(config);
}

}  // namespace firn::plant
