#include "estimators/registration/nozzle_offset.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/statistics/distributions.h"
#include "core/statistics/median.h"

namespace firn::registration {
namespace {

constexpr double kSearch = 0.35, kWindow = 0.34;  // of the marks' least distance

struct CellShift {
  int i = 0, j = 0;
};

int nearest_index(double u) { return int(std::floor(u + 0.5)); }

/// Rise between two maps, above the substrate.
class Rise {
 public:
  Rise(const HeightMap& before, const HeightMap& after, const std::vector<MarkSite>& marks)
      : rise_(after.spec, 0.0) {
    distance_mm_ = std::numeric_limits<double>::max();
    for (std::size_t a = 0; a < marks.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        distance_mm_ =
            std::min(distance_mm_, std::hypot(marks[a].x_mm - marks[b].x_mm, marks[a].y_mm - marks[b].y_mm));
    for (std::size_t c = 0; c < rise_.size(); ++c) {
      const double h = after.cells[c] - before.cells[c];
      rise_.cells[c] = std::isfinite(h) ? h : 0.0;
    }
    const double ground = statistics::upper_median(std::vector(rise_.cells));
    for (double& h : rise_.cells) h -= ground;
  }

  const GridSpec& grid() const { return rise_.spec; }
  double distance_mm() const { return distance_mm_; }
  int cells_x(double mm) const { return int(mm / grid().pitch_x_mm); }
  int cells_y(double mm) const { return int(mm / grid().pitch_y_mm); }
  int column(const MarkSite& m) const {
    return nearest_index((m.x_mm - grid().origin_x_mm) / grid().pitch_x_mm);
  }
  int row(const MarkSite& m) const {
    return nearest_index((m.y_mm - grid().origin_y_mm) / grid().pitch_y_mm);
  }
  double at(int i, int j) const { return grid().contains(i, j) ? rise_.at(i, j) : 0.0; }

  double block(int i, int j) const {
    double sum = 0.0;
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) sum += at(i + x, j + y);
    return sum;
  }

  /// The common shift of one nozzle's marks: where the most has risen, over all of them.
  CellShift common_shift(const std::vector<MarkSite>& marks, Material material) const {
    const int far_x = cells_x(kSearch * distance_mm_), far_y = cells_y(kSearch * distance_mm_);
    CellShift best;
    double most = 0.0;
    for (int j = -far_y; j <= far_y; ++j)
      for (int i = -far_x; i <= far_x; ++i) {
        double sum = 0.0;
        for (const MarkSite& m : marks)
          if (m.material == material) sum += block(column(m) + i, row(m) + j);
        if (sum > most) {
          most = sum;
          best = {i, j};
        }
      }
    if (most <= 0.0 || std::abs(best.i) == far_x || std::abs(best.j) == far_y)
      throw std::invalid_argument(std::string("registration: the marks of nozzle ") +
                                  (material == Material::kB ? "B" : "A") + " are not within " +
                                  std::to_string(kSearch * distance_mm_) +
                                  " mm of where they were meant: measure the offset roughly by hand first");
    return best;
  }

  /// Takes the mean of the ground off: of all that lies in no mark's window. A ground that is off by a little
  /// would pull every centre towards the middle of its window.
  void level(const std::vector<MarkSite>& marks, CellShift of_a, CellShift of_b) {
    Mask free(grid(), 1);
    const int wide = cells_x(kWindow * distance_mm_), high = cells_y(kWindow * distance_mm_);
    for (const MarkSite& m : marks) {
      const CellShift s = m.material == Material::kB ? of_b : of_a;
      for (int j = row(m) + s.j - high; j <= row(m) + s.j + high; ++j)
        for (int i = column(m) + s.i - wide; i <= column(m) + s.i + wide; ++i)
          if (grid().contains(i, j)) free.at(i, j) = 0;
    }
    double sum = 0.0, n = 0.0;
    for (std::size_t c = 0; c < rise_.size(); ++c)
      if (free.cells[c]) {
        sum += rise_.cells[c];
        n += 1.0;
      }
    if (n > 0.0)
      for (double& h : rise_.cells) h -= sum / n;
  }

  struct Centre {
    double volume = 0.0, x_mm = 0.0,
           y_mm = 0.0;  ///< volume in mm of height; displacement from the mark's site
  };
  Centre centre(const MarkSite& m, CellShift shift) const {
    const int wide = cells_x(kWindow * distance_mm_), high = cells_y(kWindow * distance_mm_);
    const int ci = column(m) + shift.i, cj = row(m) + shift.j;
    Centre c;
    for (int j = cj - high; j <= cj + high; ++j)
      for (int i = ci - wide; i <= ci + wide; ++i) {
        const double h = at(i, j);
        c.volume += h;
        c.x_mm += h * (grid().x_mm(i) - m.x_mm);
        c.y_mm += h * (grid().y_mm(j) - m.y_mm);
      }
    c.x_mm /= c.volume;
    c.y_mm /= c.volume;
    return c;
  }

 private:
  HeightMap rise_;
  double distance_mm_;
};

struct Sample {
  std::vector<double> x_mm, y_mm;
  int skipped = 0;
};

Sample displacements(const Rise& rise, const std::vector<MarkSite>& marks, Material material,
                     CellShift shift) {
  std::vector<Rise::Centre> centres;
  for (const MarkSite& m : marks)
    if (m.material == material) centres.push_back(rise.centre(m, shift));
  std::vector<double> volumes;
  for (const Rise::Centre& c : centres) volumes.push_back(c.volume);
  const double usual = statistics::upper_median(volumes);
  Sample s;
  for (const Rise::Centre& c : centres) {
    if (c.volume < 0.5 * usual) {
      ++s.skipped;
      continue;
    }
    s.x_mm.push_back(c.x_mm);
    s.y_mm.push_back(c.y_mm);
  }
  if (s.x_mm.size() < 4)
    throw std::invalid_argument("registration: " + std::to_string(s.x_mm.size()) +
                                " marks of a nozzle can be measured; four are the least");
  return s;
}

double mean_of(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return sum / double(v.size());
}

/// Variance of the mean.
double mean_variance(const std::vector<double>& v) {
  const double mean = mean_of(v), n = double(v.size());
  double square = 0.0;
  for (const double x : v) square += (x - mean) * (x - mean);
  return square / (n - 1.0) / n;
}

Interval difference(const std::vector<double>& b, const std::vector<double>& a) {
  const double vb = mean_variance(b), va = mean_variance(a), both = va + vb;
  Interval r;
  r.value_mm = mean_of(b) - mean_of(a);
  r.sigma_mm = std::sqrt(both);
  const double freedom =
      both > 0.0 ? both * both / (va * va / double(a.size() - 1) + vb * vb / double(b.size() - 1)) : 3.0;
  r.ci95_half_width_mm = statistics::student_t_95(freedom) * r.sigma_mm;
  return r;
}

}  // namespace

NozzleOffset measure_offset(const HeightMap& before, const HeightMap& after,
                            const std::vector<MarkSite>& marks) {
  if (before.spec != after.spec || before.size() != after.size())
    throw std::invalid_argument("registration: the two height maps are of different grids");
  const auto count = [&](Material m) { return std::ranges::count(marks, m, &MarkSite::material); };
  if (count(Material::kA) < 4 || count(Material::kB) < 4)
    throw std::invalid_argument("registration: four marks of each nozzle are the least");
  Rise rise(before, after, marks);
  const CellShift of_a = rise.common_shift(marks, Material::kA),
                  of_b = rise.common_shift(marks, Material::kB);
  rise.level(marks, of_a, of_b);
  const Sample a = displacements(rise, marks, Material::kA, of_a),
               b = displacements(rise, marks, Material::kB, of_b);
  NozzleOffset r;
  r.x = difference(b.x_mm, a.x_mm);
  r.y = difference(b.y_mm, a.y_mm);
  r.marks_a = int(a.x_mm.size());
  r.marks_b = int(b.x_mm.size());
  r.skipped = a.skipped + b.skipped;
  return r;
}

}  // namespace firn::registration
