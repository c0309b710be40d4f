#include "estimators/droplet/identification.h"

#include <algorithm>
#include <cmath>

#include "core/statistics/distributions.h"

namespace firn::droplet {
namespace {

struct Offset {
  int x, y;
};

// True when exactly `droplets` of the window of half width `half` about (i, j) hold a droplet in `fired`, and
// none in `earlier`, and the window lies on the grid.
bool only(const DropletPattern& fired, const DropletPattern& earlier, int i, int j, int half, int droplets) {
  int found = 0;
  for (int y = j - half; y <= j + half; ++y)
    for (int x = i - half; x <= i + half; ++x) {
      if (!fired.spec.contains(x, y)) continue;
      if (earlier.at(x, y)) return false;
      found += fired.at(x, y);
    }
  return found == droplets;
}

bool measured(const PrintedLayer& l, int i, int j) {
  for (int y = j - 2; y <= j + 2; ++y)
    for (int x = i - 2; x <= i + 2; ++x)
      if (!l.fired.spec.contains(x, y) || l.use[l.fired.spec.index(x, y)] != Use::kLearn) return false;
  return true;
}

double rise(const PrintedLayer& l, int i, int j) { return l.after.at(i, j) - l.before.at(i, j); }

void add_rise(Rise& sum, const PrintedLayer& l, int i, int j, Offset turn) {
  ++sum.n;
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) {
      double& mean = sum.mean_mm[y + 2][x + 2];
      mean += (rise(l, i + turn.x * x, j + turn.y * y) - mean) / sum.n;
    }
}

Repeats difference(const Repeats& a, const Repeats& b, double divisor) {
  Repeats r;
  r.n = std::min(a.n, b.n);
  r.mean_mm = (a.mean_mm - b.mean_mm) / divisor;
  const double va = a.std_error_mm * a.std_error_mm, vb = b.std_error_mm * b.std_error_mm;
  r.std_error_mm = std::sqrt(va + vb) / divisor;
  if (a.n < 2 || b.n < 2 || va + vb == 0.0) return r;
  const double freedom = (va + vb) * (va + vb) / (va * va / (a.n - 1) + vb * vb / (b.n - 1));  // Welch
  r.half_width_mm = statistics::student_t_95(freedom) * r.std_error_mm;
  return r;
}

}  // namespace

Repeats repeats_of(const std::vector<double>& values) {
  Repeats r;
  r.n = int(values.size());
  if (r.n == 0) return r;
  for (const double v : values) r.mean_mm += v / r.n;
  if (r.n < 2) return r;
  double squares = 0.0;
  for (const double v : values) squares += (v - r.mean_mm) * (v - r.mean_mm);
  r.std_error_mm = std::sqrt(squares / (r.n - 1) / r.n);
  r.half_width_mm = statistics::student_t_95(r.n - 1) * r.std_error_mm;
  return r;
}

std::vector<PrintedLayer> layers_together(const std::vector<PrintedLayer>& layers, int count) {
  std::vector<PrintedLayer> groups;
  for (std::size_t first = 0; first + std::size_t(count) <= layers.size(); first += std::size_t(count)) {
    PrintedLayer group = layers[first];
    for (std::size_t n = first + 1; n < first + std::size_t(count); ++n)
      for (std::size_t c = 0; c < group.use.size(); ++c) {
        group.fired.cells[c] = std::uint8_t(group.fired.cells[c] + layers[n].fired.cells[c]);
        if (layers[n].use[c] != Use::kLearn) group.use[c] = layers[n].use[c];
      }
    group.after = layers[first + std::size_t(count) - 1].after;
    groups.push_back(std::move(group));
  }
  return groups;
}

IdentificationPrints find_identification_prints(const std::vector<PrintedLayer>& layers, int bare) {
  IdentificationPrints p;
  if (layers.empty()) return p;
  DropletPattern earlier(layers.front().fired.spec);
  for (const PrintedLayer& l : layers) {
    const DropletPattern& u = l.fired;
    for (int j = 1; j + 1 < u.spec.ny; ++j)
      for (int i = 1; i + 1 < u.spec.nx; ++i) {
        if (u.at(i, j) != 1 || !measured(l, i, j)) continue;
        if (only(u, earlier, i, j, bare, 1)) {
          p.single.push_back(rise(l, i, j));
          p.beside.push_back(0.25 *
                             (rise(l, i + 1, j) + rise(l, i - 1, j) + rise(l, i, j + 1) + rise(l, i, j - 1)));
          p.at_corner.push_back(0.25 * (rise(l, i + 1, j + 1) + rise(l, i - 1, j + 1) +
                                        rise(l, i + 1, j - 1) + rise(l, i - 1, j - 1)));
          add_rise(p.single_rise, l, i, j, {1, 1});
        } else if (u.at(i + 1, j) == 1 && u.at(i - 1, j) == 1 && u.at(i, j + 1) == 1 && u.at(i, j - 1) == 1 &&
                   only(u, earlier, i, j, bare + 1, 5)) {
          p.cross.push_back(rise(l, i, j));
          add_rise(p.cross_rise, l, i, j, {1, 1});
        } else if (j + 1 < u.spec.ny && only(u, earlier, i, j, bare, 2)) {
          for (const int side : {1, -1}) {
            if (u.at(i + side, j + 1) != 1 || !measured(l, i + side, j + 1) ||
                !only(u, earlier, i + side, j + 1, bare, 2))
              continue;
            p.pair.push_back(0.5 * (rise(l, i, j) + rise(l, i + side, j + 1)));
            add_rise(p.pair_rise, l, i, j, {side, 1});
          }
        }
      }
    for (std::size_t c = 0; c < u.size(); ++c) earlier.cells[c] = earlier.cells[c] | u.cells[c];
  }
  p.h1 = repeats_of(p.single);
  p.h2 = difference(repeats_of(p.cross), p.h1, 4.0);
  p.h3 = difference(repeats_of(p.pair), p.h1, 1.0);
  p.side = repeats_of(p.beside);
  p.corner = repeats_of(p.at_corner);
  return p;
}

}  // namespace firn::droplet
