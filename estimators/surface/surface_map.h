// SurfaceMap estimates the height of every cell from the profiles of a laser line scan.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/grid/cell_quality.h"
#include "core/grid/grid.h"

namespace firn::surface {

/// How the samples of one cell become its height. Measured on 20 samples of 1 um noise, 0.5 % drop-outs and 2
/// % spikes of up to 50 um (tests/estimators/surface_map_test.cpp): RMS error 0.93 um for the mean, 0.27 um
/// for the median, 0.23 um for the inlier mean (0.22 is the limit by the noise), which is therefore the
/// default.
enum class CellStatistic : std::uint8_t {
  kMean,
  kMedian,
  kInlierMean,  ///< mean of the samples within 4 standard deviations (by the quartiles; at least 1 um) of the
                ///< median
};

struct MapOptions {
  CellStatistic statistic = CellStatistic::kInlierMean;
  double spike_mm = 0.05;  ///< a cell this far above or below all of its neighbours is replaced
};

struct SurfaceEstimate {
  HeightMap height;            ///< finite everywhere
  Grid<std::uint8_t> quality;  ///< of each cell, a CellQuality
  double noise_std_mm = 0.0;   ///< of one cell's height, from differences of adjacent samples; 0 = unknown
  double measured_fraction = 0.0;  ///< cells with at least one valid sample
  std::int64_t spikes = 0;         ///< cells replaced
};

/// Collects the samples of one scan. The estimate does not depend on the order of the rows.
class SurfaceMap {
 public:
  explicit SurfaceMap(const GridSpec& grid);

  /// One profile: sample n lies at x0_mm + n dx_mm on the line y_mm; NaN = no valid sample. Samples belong to
  /// the cell whose centre is nearest (within half a pitch); those off the grid are ignored.
  /// @pre x0_mm, y_mm finite, dx_mm finite and above 0
  void add_row(double y_mm, double x0_mm, double dx_mm, std::span<const float> z_mm);

  /// Cell heights; then spikes are replaced by the median of their measured neighbours; then cells without
  /// samples are filled from the rim inwards with the mean of their known neighbours. With no sample at all:
  /// 0 mm everywhere, measured_fraction 0.
  SurfaceEstimate estimate(const MapOptions& options) const;

  void clear();

 private:
  static constexpr float kNoPoint = std::numeric_limits<float>::quiet_NaN();
  double noise_of_one_sample() const;
  void pair_with_point_before(double x_mm, float z_mm);
  const std::vector<int>& columns(double x0_mm, double dx_mm, std::size_t count);

  GridSpec grid_;
  double x0_mm_ = 0.0, dx_mm_ = 0.0;  // of columns_
  std::vector<int> columns_;          // of each sample of a row, -1 off the grid; one scan's rows are alike
  std::vector<std::vector<float>> samples_;  // per cell
  std::vector<float> differences_;           // |z[n + 1] - z[n]| of every fourth pair of valid samples
  double point_x_mm_ = 0.0;                  // of the last row of one point
  float point_z_mm_ = kNoPoint;
};

}  // namespace firn::surface
