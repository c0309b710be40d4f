// The droplet-by-droplet nature: volume and covered area of each cell, in the structure of Wu and Chiu's
// height model (plant/options/wu_chiu.h); the equations are ours.
//
// A droplet of volume V on cell c meets, at each neighbour j, the height difference d = h_j - h_c before it
// landed. The neighbour's factor is piecewise linear in d, with a kink at 0:
//   f_j = 1 - m_higher d  for d >= 0,   1 - m_lower d  for d < 0,   held in 0 .. most_share
// It gets the volume V w_j f_j; the rest stays on c. Covered areas grow by the factors too: by `cover` on c,
// by cover_j f_j on j, up to the whole cell. The height is that of a column on the covered area,
//   h = v / (L^2 max(covered, least_cover)).
// Off the grid lies bare ground, h = 0, and ink there is lost. With least_cover = 1, m_lower = 0 and m_higher
// = 1 by h1 + h2 (sides) and h1 + h3 (corners) this is Eq. (5) of [Lu 2015], and with the order "pass" Eq.
// (4).
#include <algorithm>
#include <array>
#include <vector>

#include "plant/inkjet/cell_nature.h"

namespace firn::plant {
namespace {

class WuChiu final : public CellNature {
 public:
  explicit WuChiu(const WorldConfig& c)
      : CellNature(c),
        options_(c.nature.wu_chiu),
        volume_mm3_(c.grid.size(), 0.0),
        covered_(c.grid.size(), 0.0),
        met_mm_(c.grid.size(), 0.0),
        of_pass_(c.grid.size(), 0) {}

  HeightMap cell_means() const override {
    HeightMap height(grid_, 0.0);
    for (std::size_t n = 0; n < height.size(); ++n) height.cells[n] = height_mm(n);
    return height;
  }
  double volume_mm3() const override {
    double sum = 0.0;
    for (const double v : volume_mm3_) sum += v;
    return sum;
  }

 protected:
  void land(NearestCell at, double landed_mm3) override {
    const int i = at.i, j = at.j;
    const std::size_t c = grid_.index(i, j);
    const bool by_pass = options_.order == FlowOrder::kPass;
    if (by_pass && (new_pass_ || of_pass_[c] != 0)) begin_pass();
    of_pass_[c] = 1;
    // Ink shrinks as it cures, whenever that is: heights here are of cured ink.
    const double volume = landed_mm3 * (1.0 - shrink_);
    ledger_.shrunk += landed_mm3 - volume;
    const auto met = [&](std::size_t n) { return by_pass ? met_mm_[n] : height_mm(n); };
    const double own = met(c);
    std::array<double, 8> factor;
    double given = 0.0;
    for (std::size_t k = 0; k < kNeighbours.size(); ++k) {
      const auto [di, dj] = kNeighbours[k];
      const double d = (grid_.contains(i + di, j + dj) ? met(grid_.index(i + di, j + dj)) : 0.0) - own;
      const bool side = di * dj == 0;
      const double higher = side ? options_.higher_side_per_mm : options_.higher_corner_per_mm,
                   lower = side ? options_.lower_side_per_mm : options_.lower_corner_per_mm;
      factor[k] = std::clamp(1.0 - (d < 0.0 ? lower : higher) * d, 0.0, options_.most_share);
      given += share(k) * factor[k];
    }
    const double held = given > 1.0 ? 1.0 / given : 1.0;  // no more than the droplet can be given
    for (std::size_t k = 0; k < kNeighbours.size(); ++k) {
      const auto [di, dj] = kNeighbours[k];
      const double gift = volume * share(k) * factor[k] * held;
      if (!grid_.contains(i + di, j + dj)) {
        ledger_.lost += gift;
        continue;
      }
      const std::size_t n = grid_.index(i + di, j + dj);
      volume_mm3_[n] += gift;
      cover(n, (di * dj == 0 ? options_.cover_side : options_.cover_corner) * factor[k]);
    }
    volume_mm3_[c] += volume * (1.0 - std::min(given, 1.0));
    cover(c, options_.cover);
  }
  void settle() override { new_pass_ = true; }
  void cure() override {}
  void io_cells(Archive& a) override { a.all(volume_mm3_, covered_, met_mm_, of_pass_, new_pass_); }

 private:
  struct Step {
    int di, dj;
  };
  static constexpr std::array<Step, 8> kNeighbours{
      {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

  double share(std::size_t k) const {
    return kNeighbours[k].di * kNeighbours[k].dj == 0 ? options_.side_share : options_.corner_share;
  }
  double height_mm(std::size_t n) const {
    return volume_mm3_[n] / (area_mm2() * std::max(covered_[n], options_.least_cover));
  }
  void cover(std::size_t n, double more) { covered_[n] = std::min(1.0, covered_[n] + more); }
  void begin_pass() {
    for (std::size_t n = 0; n < met_mm_.size(); ++n) met_mm_[n] = height_mm(n);
    std::fill(of_pass_.begin(), of_pass_.end(), std::uint8_t{0});
    new_pass_ = false;
  }

  WuChiuOptions options_;
  std::vector<double> volume_mm3_;     ///< cured ink on each cell
  std::vector<double> covered_;        ///< part of each cell's area
  std::vector<double> met_mm_;         ///< heights at the start of the pass
  std::vector<std::uint8_t> of_pass_;  ///< cells that got a droplet in it
  bool new_pass_ = true;               ///< the next droplet begins one
};

}  // namespace

std::unique_ptr<Model> make_wu_chiu_model(const WorldConfig& config) {
  return std::make_unique<WuChiu>(config);
}

}  // namespace firn::plant
