#include "estimators/droplet/excitation.h"

#include <cmath>

#include "estimators/droplet/symmetric3.h"

namespace firn::droplet {
namespace {

struct Near {
  double own = 0.0, sides = 0.0, corners = 0.0;
  bool even = true;  // all nine cells on the grid have the same number
};

Near near_of(const DropletPattern& u, int i, int j) {
  Near n;
  n.own = u.at(i, j);
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      if (x == 0 && y == 0) continue;
      const bool inside = u.spec.contains(i + x, j + y);
      const double fired = inside ? u.at(i + x, j + y) : 0.0;
      n.even = n.even && inside && fired == n.own;
      (x == 0 || y == 0 ? n.sides : n.corners) += fired;
    }
  return n;
}

}  // namespace

DesignExcitation design_excitation(const std::vector<PrintedLayer>& layers) {
  DesignExcitation d;
  Symmetric3 moments;
  for (const PrintedLayer& l : layers)
    for (int j = 0; j < l.fired.spec.ny; ++j)
      for (int i = 0; i < l.fired.spec.nx; ++i) {
        const Use use = l.use[l.fired.spec.index(i, j)];
        if (use == Use::kNothing) continue;
        const Near n = near_of(l.fired, i, j);
        d.own = d.own || n.own > 0.0;
        d.sides = d.sides || n.sides > 0.0;
        d.corners = d.corners || n.corners > 0.0;
        if (use != Use::kLearn) continue;
        const std::array<double, 3> x{n.own, n.sides, n.corners};
        for (int r = 0; r < 3; ++r)
          for (int q = 0; q < 3; ++q) moments.at(r, q) += x[std::size_t(r)] * x[std::size_t(q)];
      }
  d.excitation = separation(moments);
  return d;
}

std::string unseen_constants(const DesignExcitation& d) {
  std::string names;
  for (const auto& [seen, name] : {std::pair{d.own, "h1"}, {d.sides, "h2"}, {d.corners, "h3"}})
    if (!seen) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

Repeats layer_height_of_even_cells(const std::vector<PrintedLayer>& layers) {
  std::vector<double> heights;
  for (const PrintedLayer& l : layers) {
    double rise = 0.0, drops = 0.0;
    for (int j = 0; j < l.fired.spec.ny; ++j)
      for (int i = 0; i < l.fired.spec.nx; ++i) {
        const Near n = near_of(l.fired, i, j);
        if (!n.even || n.own == 0.0 || l.use[l.fired.spec.index(i, j)] != Use::kLearn) continue;
        rise += l.after.at(i, j) - l.before.at(i, j);
        drops += n.own;
      }
    if (drops > 0.0) heights.push_back(rise / drops);
  }
  return repeats_of(heights);
}

}  // namespace firn::droplet
