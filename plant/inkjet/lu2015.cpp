// The paper's own simulation [Lu 2015, Eqs. (3)-(5), V-A]: core/deposition with h1..h3 all times (1 + v
// U[0,1]), drawn per droplet and layer (errata, FIT). Droplets arrive one by one; (4) needs a whole pass, and
// is linear in the pattern for the height at its start, so a pass is collected and applied at once when it
// ends: at the jet's disarming, a second droplet on one cell, an exposure or a measurement, whichever comes
// first. With two inks (Eqs. (6), (7)) the jets take turns, and a layer's pass is over only when both have
// fired: disarming ends nothing there. The support's constants are ratio_b times the object's.
#include <algorithm>

#include "core/deposition/two_materials.h"
#include "core/grid/random.h"
#include "plant/inkjet/model.h"

namespace firn::plant {
namespace {

using deposition::HeightChange;
using deposition::Stencil;

class Lu2015Model : public Model {
 public:
  explicit Lu2015Model(const WorldConfig& c)
      : grid_(c.grid),
        params_(c.lu2015),
        seed_(c.seed),
        nominal_(deposition::stencil_of({params_.h1_mm, params_.h2_mm, params_.h3_mm})),
        change_(c.grid, nominal_,
                params_.keep_border ? deposition::Border::kKeep : deposition::Border::kLose),
        height_(c.grid, 0.0),
        pending_(c.grid.size(), 0),
        stencils_(c.grid.size(), nominal_),
        attempts_(c.grid.size(), 0),
        shown_(c.grid, 1, 0),
        two_inks_(c.two_inks),
        ratio_b_(c.ratio_b) {
    if (!two_inks_) return;
    inks_ = MaterialMap(c.grid, std::uint8_t(Material::kA));
    columns_ = MaterialColumns(c.grid);
  }

  Landing fire(const Shot& shot) override {
    const NearestCell cell = nearest_cell(grid_, shot.x_mm, shot.y_mm);
    Landing out{false, 0.0, shot.x_mm, shot.y_mm};
    const double size = shot.ink == Material::kB ? ratio_b_ : 1.0;
    if (!grid_.contains(cell.i, cell.j)) {
      out.volume_mm3 = size * nominal_.drop_height_mm() * area_mm2();
      ledger_.landed += out.volume_mm3;
      ledger_.lost += out.volume_mm3;
      return out;
    }
    const std::size_t n = grid_.index(cell.i, cell.j);
    if (pending_[n] != 0) settle();
    const double factor =
        size * (1.0 + params_.variation * random_uniform({seed_, Purpose::kModelVariation, layers_.layer(),
                                                          attempts_[n]++, cell_key(cell)}));
    stencils_[n] = nominal_;
    stencils_[n].centre_mm *= factor;
    for (double& weight : stencils_[n].ring_mm) weight *= factor;
    if (two_inks_) inks_.set(n, shot.ink);
    pending_[n] = 1;
    any_pending_ = true;
    out.volume_mm3 = stencils_[n].drop_height_mm() * area_mm2();
    return out;
  }

  void end_pass() override {
    if (!two_inks_) settle();
  }
  void settle() {
    if (!any_pending_) return;
    const deposition::Ledger step =
        two_inks_ ? deposition::step_with_columns(change_, height_, pending_, 0, stencils_, inks_, columns_)
                  : change_.step(height_.data(), pending_.data(), 0, stencils_);
    ledger_.landed += step.deposited_mm * area_mm2();
    ledger_.lost += step.lost_mm * area_mm2();
    std::fill(pending_.begin(), pending_.end(), std::uint8_t{0});
    any_pending_ = false;
  }
  void expose(std::int64_t) override {
    settle();
    layers_.exposed();
  }
  void measured() override {
    if (layers_.measured()) std::fill(attempts_.begin(), attempts_.end(), 0u);
  }
  const Field& surface() override {
    settle();
    for (int j = 0; j < grid_.ny; ++j)
      for (int i = 0; i < grid_.nx; ++i) shown_.set_solid_mm(i, j, height_.at(i, j));
    return shown_;
  }
  HeightMap cell_means() const override {
    if (!any_pending_) return height_;
    HeightMap settled = height_;
    HeightChange<1> change(grid_, nominal_, change_.border());
    change.step(settled.data(), pending_.data(), 0, stencils_);
    return settled;
  }
  VolumeLedger ledger() const override { return ledger_; }
  double volume_mm3() const override {
    double sum = 0.0;
    for (const double z : cell_means().cells) sum += z;
    return sum * area_mm2();
  }
  const LayerCount& layers() const override { return layers_; }
  MaterialColumns materials() const override {
    if (!two_inks_ || !any_pending_) return columns_;
    MaterialColumns settled = columns_;
    HeightMap height = height_;
    HeightChange<1> change(grid_, nominal_, change_.border());
    deposition::step_with_columns(change, height, pending_, 0, stencils_, inks_, settled);
    return settled;
  }
  void io(Archive& a) override {
    a.all(height_.cells, pending_, stencils_, attempts_, layers_, any_pending_, ledger_);
    if (two_inks_) a.all(inks_.cells, columns_);
  }

 private:
  double area_mm2() const { return grid_.pitch_x_mm * grid_.pitch_y_mm; }

  GridSpec grid_;
  Lu2015Params params_;
  std::uint64_t seed_;
  Stencil<1> nominal_;
  HeightChange<1> change_;
  HeightMap height_;
  std::vector<std::uint8_t> pending_;    ///< droplets of the pass that has not been applied
  std::vector<Stencil<1>> stencils_;     ///< of those droplets
  std::vector<std::uint32_t> attempts_;  ///< droplets per cell of this layer
  LayerCount layers_;
  bool any_pending_ = false;
  VolumeLedger ledger_;
  Field shown_;  ///< height_ as the sensor's input
  bool two_inks_;
  double ratio_b_;
  MaterialMap inks_;         ///< of the pending droplets; no cells with one ink
  MaterialColumns columns_;  ///< no cells with one ink
};

}  // namespace

std::unique_ptr<Model> make_lu2015_model(const WorldConfig& config) {
  return std::make_unique<Lu2015Model>(config);
}

}  // namespace firn::plant
