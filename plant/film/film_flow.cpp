#include "plant/film/film_flow.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/grid/cosine_transform.h"
#include "plant/ode/cvode_krylov.h"

namespace firn::plant {
namespace {

double mobility(MobilityPower power, double a, double b) {
  if (power == MobilityPower::kOne) return std::max(0.0, 0.5 * (a + b));
  if (!(a > 0.0) || !(b > 0.0)) return 0.0;
  return 2.0 * a * a * (b * b) / (a + b);
}

/// The same for gravity, whose flux on level ground is then the difference of h^4 / 4. Nothing leaves a dry
/// cell.
double gravity_mobility(MobilityPower power, double a, double b, bool from_a) {
  if (!((from_a ? a : b) > 0.0)) return 0.0;
  return power == MobilityPower::kOne ? 0.5 * (a + b) : 0.25 * (a + b) * (a * a + b * b);
}

}  // namespace

/// CVODE and the preconditioner of one film.
struct FilmSolver {
  FilmFlow& film;
  CosineTransform transform;
  std::vector<double> wave;   ///< k^2 of each wave
  std::vector<double> scale;  ///< 1 / (1 + c m_ref (...)) of each wave
  std::vector<double> work;
  double reference = 0.0;  ///< m_ref
  double wet_cells = 0.0;
  CvodeKrylov cvode;

  explicit FilmSolver(FilmFlow& f)
      : film(f),
        transform(f.grid_.nx, f.grid_.ny),
        wave(f.grid_.size()),
        scale(f.grid_.size()),
        work(f.grid_.size()),
        cvode("thin film", sunindextype(f.grid_.size()), &rate, &set_up, &solve, f.law_.relative,
              f.law_.absolute, this) {
    const std::vector<double> x = CosineTransform::eigenvalues(f.grid_.nx, f.grid_.dx),
                              y = CosineTransform::eigenvalues(f.grid_.ny, f.grid_.dy);
    for (int j = 0; j < f.grid_.ny; ++j)
      for (int i = 0; i < f.grid_.nx; ++i)
        wave[std::size_t(j) * std::size_t(f.grid_.nx) + std::size_t(i)] =
            x[std::size_t(i)] + y[std::size_t(j)];
  }

  static int rate(double, N_Vector h, N_Vector rate, void* user) {
    const auto& self = *static_cast<FilmSolver*>(user);
    self.film.rate_of(NV_DATA_S(h), NV_DATA_S(rate));
    ++self.film.work_.slopes;
    return 0;
  }
  static int set_up(double, N_Vector h, N_Vector, int, int* current, double c, void* user) {
    auto& self = *static_cast<FilmSolver*>(user);
    const FilmLaw& law = self.film.law_;
    const double* height = NV_DATA_S(h);
    double most = 0.0;
    self.wet_cells = 0.0;
    for (std::size_t n = 0; n < self.work.size(); ++n) {
      if (!self.film.wet_[n]) continue;
      most = std::max(most, height[n]);
      self.wet_cells += 1.0;
    }
    const double reference = law.power == MobilityPower::kOne ? most : most * most * most;
    for (std::size_t n = 0; n < self.wave.size(); ++n)
      self.scale[n] =
          1.0 / (1.0 + c * reference * self.wave[n] * (law.capillary * self.wave[n] + law.gravity));
    *current = 1;
    return 0;
  }
  static int solve(double, N_Vector, N_Vector, N_Vector r, N_Vector z, double, double, int, void* user) {
    auto& self = *static_cast<FilmSolver*>(user);
    const double* given = NV_DATA_S(r);
    double* answer = NV_DATA_S(z);
    std::copy_n(given, self.work.size(), self.work.data());
    self.transform.forward(self.work.data());
    for (std::size_t n = 0; n < self.work.size(); ++n) self.work[n] *= self.scale[n];
    self.transform.inverse(self.work.data());
    // Dry cells keep theirs; the wet ones share the rest, so that the sum is kept.
    double rest = 0.0;
    for (std::size_t n = 0; n < self.work.size(); ++n) {
      answer[n] = self.film.wet_[n] ? self.work[n] : given[n];
      rest += given[n] - answer[n];
    }
    if (self.wet_cells > 0.0)
      for (std::size_t n = 0; n < self.work.size(); ++n)
        if (self.film.wet_[n]) answer[n] += rest / self.wet_cells;
    return 0;
  }
};

FilmFlow::FilmFlow(const FilmGrid& grid, const FilmLaw& law)
    : grid_(grid),
      law_(law),
      height_(grid.size(), 0.0),
      ground_(grid.size(), 0.0),
      wet_(grid.size(), 1),
      open_x_(grid.size(), 0),
      open_y_(grid.size(), 0),
      inner_x_(grid.size(), 0),
      inner_y_(grid.size(), 0),
      surface_(grid.size(), 0.0),
      slope_x_(grid.size(), 0.0),
      slope_y_(grid.size(), 0.0),
      push_(grid.size(), 0.0),
      bend_x_(law.full_curvature ? grid.size() : 0, 0.0),
      bend_y_(bend_x_.size(), 0.0),
      solver_(std::make_unique<FilmSolver>(*this)) {
  if (grid.nx < 1 || grid.ny < 1 || !(grid.dx > 0.0) || !(grid.dy > 0.0))
    throw std::invalid_argument("thin film: a grid has 1 cell or more of a size above 0");
  faces_changed(INFINITY);
}
FilmFlow::~FilmFlow() = default;

void FilmFlow::faces_changed(double steepest_ground) {
  const auto nx = std::size_t(grid_.nx);
  const auto open = [&](std::size_t a, std::size_t b, double d) {
    return wet_[a] && wet_[b] && std::abs(ground_[a] - ground_[b]) <= steepest_ground * d;
  };
  for (std::size_t n = 0; n < grid_.size(); ++n) {
    open_x_[n] = (n + 1) % nx != 0 && open(n, n + 1, grid_.dx);
    open_y_[n] = n + nx < grid_.size() && open(n, n + nx, grid_.dy);
  }
  // Inner faces have an open one, or a wall, on either side.
  for (std::size_t n = 0; n < grid_.size(); ++n) {
    const std::size_t i = n % nx;
    inner_x_[n] = open_x_[n] && (i == 0 || open_x_[n - 1]) && (i + 2 == nx || open_x_[n + 1]);
    inner_y_[n] =
        open_y_[n] && (n < nx || open_y_[n - nx]) && (n + 2 * nx >= grid_.size() || open_y_[n + nx]);
  }
  find_bodies();
}

void FilmFlow::find_bodies() {
  constexpr std::int32_t kNone = -1;
  const auto row = std::size_t(grid_.nx);
  body_.assign(grid_.size(), kNone);
  bodies_ = 0;
  std::vector<std::size_t> waiting;
  for (std::size_t first = 0; first < grid_.size(); ++first) {
    if (!wet_[first] || body_[first] != kNone) continue;
    const auto reach = [&](std::size_t n) {
      if (body_[n] != kNone) return;
      body_[n] = bodies_;
      waiting.push_back(n);
    };
    reach(first);
    while (!waiting.empty()) {
      const std::size_t n = waiting.back();
      waiting.pop_back();
      if (open_x_[n]) reach(n + 1);
      if (open_y_[n]) reach(n + row);
      if (n >= 1 && open_x_[n - 1]) reach(n - 1);
      if (n >= row && open_y_[n - row]) reach(n - row);
    }
    ++bodies_;
  }
}

std::vector<double> FilmFlow::volumes() const {
  std::vector<double> volume(std::size_t(bodies_), 0.0);
  for (std::size_t n = 0; n < grid_.size(); ++n)
    if (body_[n] >= 0) volume[std::size_t(body_[n])] += height_[n];
  return volume;
}

void FilmFlow::push_of(const double* h) const {
  const int nx = grid_.nx, ny = grid_.ny;
  const auto row = std::size_t(nx);
  const std::size_t cells = grid_.size();
  for (std::size_t n = 0; n < cells; ++n) surface_[n] = ground_[n] + h[n];
  // Slopes at the open faces. The third difference takes out the leading error of all four differences
  // between h and its rate, for a film of even mobility.
  const auto slopes = [&](const std::vector<std::uint8_t>& open, const std::vector<std::uint8_t>& inner,
                          std::size_t step, double d, std::vector<double>& slope) {
    for (std::size_t n = 0; n < cells; ++n) {
      if (!open[n]) continue;
      const double here = surface_[n + step] - surface_[n];
      double rise = here;
      if (inner[n]) {
        const double before = n >= step && open[n - step] ? surface_[n] - surface_[n - step] : 0.0,
                     after = open[n + step] ? surface_[n + 2 * step] - surface_[n + step] : 0.0;
        rise -= (after - 2.0 * here + before) / 6.0;
      }
      slope[n] = rise / d;
    }
  };
  slopes(open_x_, inner_x_, 1, grid_.dx, slope_x_);
  slopes(open_y_, inner_y_, row, grid_.dy, slope_y_);

  struct Slopes {
    double right, left, up,
        down;  ///< along the axes; 0 at a wall, to the contact line at another closed face
  };
  const auto slopes_at = [&](std::size_t n, int i, int j) {
    const double x = 2.0 * h[n] / grid_.dx, y = 2.0 * h[n] / grid_.dy;
    return Slopes{i + 1 == nx  ? 0.0
                  : open_x_[n] ? slope_x_[n]
                               : -x,
                  i == 0           ? 0.0
                  : open_x_[n - 1] ? slope_x_[n - 1]
                                   : x,
                  j + 1 == ny  ? 0.0
                  : open_y_[n] ? slope_y_[n]
                               : -y,
                  j == 0             ? 0.0
                  : open_y_[n - row] ? slope_y_[n - row]
                                     : y};
  };
  if (law_.full_curvature)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const std::size_t n = std::size_t(j) * row + std::size_t(i);
        if (!wet_[n]) continue;
        const Slopes s = slopes_at(n, i, j);
        const double x = 0.5 * (s.right + s.left), y = 0.5 * (s.up + s.down);
        bend_x_[n] = x * x;
        bend_y_[n] = y * y;
      }
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const std::size_t n = std::size_t(j) * row + std::size_t(i);
      if (!wet_[n]) continue;
      Slopes s = slopes_at(n, i, j);
      if (law_.full_curvature) {
        const auto across = [&](const std::vector<double>& bend, bool is_open, std::size_t m) {
          return is_open ? 0.5 * (bend[n] + bend[m]) : bend[n];
        };
        s.right /= std::sqrt(1.0 + s.right * s.right + across(bend_y_, open_x_[n], n + 1));
        s.left /= std::sqrt(1.0 + s.left * s.left + across(bend_y_, i > 0 && open_x_[n - 1], n - 1));
        s.up /= std::sqrt(1.0 + s.up * s.up + across(bend_x_, open_y_[n], n + row));
        s.down /= std::sqrt(1.0 + s.down * s.down + across(bend_x_, j > 0 && open_y_[n - row], n - row));
      }
      const double curvature = (s.right - s.left) / grid_.dx + (s.up - s.down) / grid_.dy;
      push_[n] = -law_.capillary * curvature;
    }
}

void FilmFlow::rate_of(const double* h, double* rate) const {
  push_of(h);
  std::fill_n(rate, grid_.size(), 0.0);
  const auto row = std::size_t(grid_.nx);
  const double by_x = 1.0 / (grid_.dx * grid_.dx), by_y = 1.0 / (grid_.dy * grid_.dy);
  const auto pass = [&](std::size_t n, std::size_t m, double by) {
    double gain = mobility(law_.power, h[n], h[m]) * (push_[m] - push_[n]);
    if (law_.gravity > 0.0) {
      const double fall = surface_[m] - surface_[n];
      gain += law_.gravity * gravity_mobility(law_.power, h[n], h[m], fall < 0.0) * fall;
    }
    rate[n] += gain * by;
    rate[m] -= gain * by;
  };
  for (std::size_t n = 0; n < grid_.size(); ++n) {
    if (open_x_[n]) pass(n, n + 1, by_x);
    if (open_y_[n]) pass(n, n + row, by_y);
  }
}

std::vector<double> FilmFlow::rate() const {
  std::vector<double> rate(grid_.size());
  rate_of(height_.data(), rate.data());
  return rate;
}

void FilmFlow::flow(double duration) {
  if (!(duration > 0.0)) return;
  const std::vector<double> before = volumes();
  CvodeKrylov& cvode = solver_->cvode;
  double* y = NV_DATA_S(cvode.y);
  std::copy(height_.begin(), height_.end(), y);
  cvode.require(CVodeReInit(cvode.memory, 0.0, cvode.y), "CVodeReInit");
  cvode.require(CVodeSetStopTime(cvode.memory, duration), "CVodeSetStopTime");
  double reached = 0.0;
  cvode.require(CVode(cvode.memory, duration, cvode.y, &reached, CV_NORMAL), "CVode");
  std::copy_n(y, height_.size(), height_.begin());
  // GMRES stops at a tolerance, and the rest of the residual is volume that came or went: a millionth.
  const std::vector<double> after = volumes();
  for (std::size_t n = 0; n < height_.size(); ++n)
    if (const std::int32_t body = body_[n]; body >= 0 && after[std::size_t(body)] > 0.0)
      height_[n] *= before[std::size_t(body)] / after[std::size_t(body)];
  long steps = 0, newton = 0, krylov = 0;
  CVodeGetNumSteps(cvode.memory, &steps);
  CVodeGetNumNonlinSolvIters(cvode.memory, &newton);
  CVodeGetNumLinIters(cvode.memory, &krylov);
  work_.steps += steps;
  work_.newton += newton;
  work_.krylov += krylov;
}

}  // namespace firn::plant
