// The graph nature: droplets of fixed shape are superposed, then wet ink flows along the edges of a graph
// whose nodes are cells, in the structure of Guo, Peters, Oomen and Mishra's models
// (plant/options/graph_flow.h); the equations are ours.
//
// H is the cured height and v the wet one of each node. A droplet adds B u to v. With D the incidence matrix
// of the edges to side and corner neighbours, each step of flow is
//   q = K sat(D'(H + v)),   v <- v - D q
// K = kappa_side or kappa_corner, sat holding a difference within +-range_mm. A node whose edges ask for more
// than it has wet gives each the same part of it, so that v >= 0. Every column of D sums to 0: no step
// changes the volume. The lamp adds v to H, less the shrinkage.
#include <algorithm>
#include <vector>

#include "plant/inkjet/cell_nature.h"

namespace firn::plant {
namespace {

class GraphFlow final : public CellNature {
 public:
  explicit GraphFlow(const WorldConfig& c)
      : CellNature(c),
        options_(c.nature.graph_flow),
        width_(c.grid.nx + 2 * options_.margin_cells),
        depth_(c.grid.ny + 2 * options_.margin_cells),
        solid_mm_(std::size_t(width_) * std::size_t(depth_), 0.0),
        wet_mm_(solid_mm_.size(), 0.0) {}

  HeightMap cell_means() const override { return means(0); }
  HeightMap means_with_margin() const override { return means(options_.margin_cells); }
  double volume_mm3() const override {
    double sum = 0.0;
    for (std::size_t n = 0; n < wet_mm_.size(); ++n) sum += solid_mm_[n] + wet_mm_[n];
    return sum * area_mm2();
  }

 protected:
  void land(NearestCell at, double volume_mm3) override {
    const double height = volume_mm3 / area_mm2();
    const double own = 1.0 - 4.0 * options_.side_share - 4.0 * options_.corner_share;
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di)
        wet_mm_[node(at.i + di, at.j + dj)] += height * (di == 0 && dj == 0 ? own
                                                         : di * dj == 0     ? options_.side_share
                                                                            : options_.corner_share);
    flows_ = true;
  }
  void settle() override {
    if (flows_)
      for (int n = 0; n < options_.steps; ++n) step(wet_mm_);
    flows_ = false;
  }
  void cure() override {
    for (std::size_t n = 0; n < wet_mm_.size(); ++n) {
      solid_mm_[n] += (1.0 - shrink_) * wet_mm_[n];
      ledger_.shrunk += shrink_ * wet_mm_[n] * area_mm2();
      wet_mm_[n] = 0.0;
    }
  }
  void io_cells(Archive& a) override { a.all(solid_mm_, wet_mm_, flows_); }

 private:
  std::size_t node(int i, int j) const {
    return std::size_t(j + options_.margin_cells) * std::size_t(width_) +
           std::size_t(i + options_.margin_cells);
  }
  HeightMap means(int margin) const {
    GridSpec grid = grid_;
    grid.nx += 2 * margin;
    grid.ny += 2 * margin;
    grid.origin_x_mm -= margin * grid.pitch_x_mm;
    grid.origin_y_mm -= margin * grid.pitch_y_mm;
    HeightMap height(grid, 0.0);
    std::vector<double> settled;  // of a pass that is under way
    if (flows_) {
      settled = wet_mm_;
      for (int n = 0; n < options_.steps; ++n) step(settled);
    }
    const std::vector<double>& wet = flows_ ? settled : wet_mm_;
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const std::size_t n = node(i - margin, j - margin);
        height.at(i, j) = solid_mm_[n] + wet[n];
      }
    return height;
  }

  /// Calls f(a, b, kappa) for every edge.
  template <class F>
  void each_edge(F&& f) const {
    const auto at = [&](int i, int j) { return std::size_t(j) * std::size_t(width_) + std::size_t(i); };
    for (int j = 0; j < depth_; ++j)
      for (int i = 0; i < width_; ++i) {
        const std::size_t n = at(i, j);
        if (i + 1 < width_) f(n, at(i + 1, j), options_.kappa_side);
        if (j + 1 == depth_) continue;
        f(n, at(i, j + 1), options_.kappa_side);
        if (i + 1 < width_) f(n, at(i + 1, j + 1), options_.kappa_corner);
        if (i > 0) f(n, at(i - 1, j + 1), options_.kappa_corner);
      }
  }
  double flow_mm(const std::vector<double>& wet, std::size_t a, std::size_t b, double kappa) const {
    const double d = (solid_mm_[a] + wet[a]) - (solid_mm_[b] + wet[b]);
    return kappa * std::clamp(d, -options_.range_mm, options_.range_mm);
  }
  void step(std::vector<double>& wet) const {
    std::vector<double> asked(wet.size(), 0.0), change(wet.size(), 0.0);
    each_edge([&](std::size_t a, std::size_t b, double kappa) {
      const double q = flow_mm(wet, a, b, kappa);
      asked[q > 0.0 ? a : b] += q > 0.0 ? q : -q;
    });
    each_edge([&](std::size_t a, std::size_t b, double kappa) {
      double q = flow_mm(wet, a, b, kappa);
      const std::size_t giver = q > 0.0 ? a : b;
      if (asked[giver] > wet[giver]) q *= wet[giver] / asked[giver];
      change[a] -= q;
      change[b] += q;
    });
    for (std::size_t n = 0; n < wet.size(); ++n) wet[n] = std::max(0.0, wet[n] + change[n]);
  }

  GraphFlowOptions options_;
  int width_, depth_;  ///< nodes, with the margin
  std::vector<double> solid_mm_, wet_mm_;
  bool flows_ = false;  ///< ink has landed since it last came to rest
};

}  // namespace

std::unique_ptr<Model> make_graph_flow_model(const WorldConfig& config) {
  return std::make_unique<GraphFlow>(config);
}

}  // namespace firn::plant
