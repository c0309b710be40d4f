// FilmFlow computes the flow of a thin liquid film on uneven ground by lubrication theory, on a rectangular
// grid with walls.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace firn::plant {

/// Mobility h^n of a film: 3 for a film that sticks to its ground, 1 for a test whose solution is known.
enum class MobilityPower : std::uint8_t { kOne = 1, kThree = 3 };

/// Coefficients of h_t = div( h^n grad( gravity z - capillary kappa ) ), z = ground + h, kappa the curvature
/// of z.
struct FilmLaw {
  double capillary = 0.0;  ///< surface tension / (3 viscosity); lengths and times have the caller's units
  double gravity = 0.0;    ///< density x gravity / (3 viscosity)
  MobilityPower power = MobilityPower::kThree;
  bool full_curvature = false;              ///< kappa = div(grad z / sqrt(1 + |grad z|^2)), else lap z
  double relative = 1e-4, absolute = 1e-7;  ///< tolerances of h
};

struct FilmGrid {
  int nx = 1, ny = 1;
  double dx = 1.0, dy = 1.0;
  std::size_t size() const { return std::size_t(nx) * std::size_t(ny); }
};

/// Sums of the work since the film was made.
struct FilmWork {
  std::int64_t steps = 0, newton = 0, krylov = 0, slopes = 0;  ///< slopes: evaluations of h_t
};

/// A cell is wet or dry. Between a wet and a dry cell lies a pinned contact line: nothing flows there, and
/// the surface meets the ground of the wet cell at the face. Walls reflect.
///
/// Flux of surface tension through a face between wet cells a and b: m (P_b - P_a) / dx, P = -capillary
/// kappa. For n = 3 the mobility is m = 2 a^2 b^2 / (a + b) = (a - b) / (G'(a) - G'(b)) with G'' = h^-3, the
/// entropy-preserving mean of L. Zhornitskaya and A. L. Bertozzi, SIAM J. Numer. Anal. 37 (2000) 523, with
/// which h stays above 0; for n = 1 it is (a + b) / 2. Gravity's is (a + b)(a^2 + b^2) / 4. CVODE solves the
/// semi-discrete equations: BDF, Newton, GMRES, preconditioned by I + c m_ref (capillary lap^2 - gravity lap)
/// in the cosine transform, m_ref the largest mobility of a wet cell. Each body of liquid, of cells that open
/// faces join, keeps its volume to rounding: it is scaled to it after each flow.
class FilmFlow {
 public:
  FilmFlow(const FilmGrid& grid, const FilmLaw& law);
  ~FilmFlow();
  FilmFlow(FilmFlow&&) noexcept;

  const FilmGrid& grid() const { return grid_; }
  std::vector<double>& height() { return height_; }  ///< h
  const std::vector<double>& height() const { return height_; }
  std::vector<double>& ground() { return ground_; }
  const std::vector<double>& ground() const { return ground_; }
  /// 1: wet; all cells at first. Call faces_changed() after a change of it or of the ground.
  std::vector<std::uint8_t>& wet() { return wet_; }
  const std::vector<std::uint8_t>& wet() const { return wet_; }
  /// @param steepest_ground slope of the ground between two wet cells over which liquid flows; beyond it both
  /// have a contact line of their own at the face, as at the rim of a part
  void faces_changed(double steepest_ground);

  /// Advances by `duration`. @throws std::runtime_error naming CVODE's call when it fails
  void flow(double duration);
  /// h_t of the present film.
  std::vector<double> rate() const;
  const FilmWork& work() const { return work_; }

 private:
  friend struct FilmSolver;
  void rate_of(const double* h, double* rate) const;
  void push_of(const double* h) const;
  void find_bodies();
  std::vector<double> volumes() const;  ///< sum of h of each body

  FilmGrid grid_;
  FilmLaw law_;
  std::vector<double> height_, ground_;
  std::vector<std::uint8_t> wet_;
  std::vector<std::uint8_t> open_x_, open_y_;    ///< face between a cell and its next one: liquid flows
  std::vector<std::uint8_t> inner_x_, inner_y_;  ///< likewise, with an open face or a wall on either side
  mutable std::vector<double> surface_, slope_x_, slope_y_;
  mutable std::vector<double> push_;             ///< -capillary kappa of each cell
  mutable std::vector<double> bend_x_, bend_y_;  ///< full curvature: squares of the cells' slopes
  std::vector<std::int32_t> body_;               ///< of each wet cell; -1: dry
  std::int32_t bodies_ = 0;
  FilmWork work_;
  std::unique_ptr<struct FilmSolver> solver_;
};

}  // namespace firn::plant
