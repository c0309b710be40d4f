// CellNature is the base of the natures whose surface is a height for each cell of the grid: it lands the
// droplets on cells, counts layers, keeps the ledger and shows the cells to the sensor as steps.
#pragma once

#include <cstdint>

#include "plant/inkjet/droplet_source.h"
#include "plant/inkjet/model.h"

namespace firn::plant {

class CellNature : public Model {
 public:
  explicit CellNature(const WorldConfig& c)
      : grid_(c.grid), shrink_(c.droplet.cure_shrink), source_(c), shown_(c.grid, 1, 0) {}

  Landing fire(const Shot& shot) final {
    const Landing out = source_.fire(shot, layers_.layer(), false);
    ledger_.landed += out.volume_mm3;
    if (out.missed) return out;
    const NearestCell cell = nearest_cell(grid_, out.x_mm, out.y_mm);
    if (grid_.contains(cell.i, cell.j))
      land(cell, out.volume_mm3);
    else
      ledger_.lost += out.volume_mm3;
    return out;
  }
  void end_pass() final { settle(); }
  void expose(std::int64_t now_us) final {
    settle();
    cure();
    if (layers_.exposed()) source_.cured(now_us, layers_.layer() + 1);
  }
  void measured() final {
    if (layers_.measured()) source_.measured();
  }
  const Field& surface() final {
    settle();
    const HeightMap height = cell_means();
    for (int j = 0; j < grid_.ny; ++j)
      for (int i = 0; i < grid_.nx; ++i) shown_.set_solid_mm(i, j, height.at(i, j));
    return shown_;
  }
  VolumeLedger ledger() const final { return ledger_; }
  const LayerCount& layers() const final { return layers_; }
  MaterialColumns materials() const final { return {}; }
  void io(Archive& a) final {
    a.all(source_, layers_, ledger_);
    io_cells(a);
  }

 protected:
  virtual void land(NearestCell cell, double volume_mm3) = 0;  ///< a cell of the grid
  virtual void settle() = 0;                                   ///< a pass is over: its ink comes to rest
  virtual void cure() = 0;
  virtual void io_cells(Archive& a) = 0;

  double area_mm2() const { return grid_.pitch_x_mm * grid_.pitch_y_mm; }

  GridSpec grid_;
  double shrink_;  ///< share of the liquid's volume that the lamp removes
  VolumeLedger ledger_;

 private:
  DropletSource source_;
  LayerCount layers_;
  Field shown_;  ///< the heights as the sensor's input
};

}  // namespace firn::plant
