#include "estimators/surface/surface_map.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::surface;

namespace {

const GridSpec kGrid{12, 9, 0.25, 0.3, 1.0, -1.0};
constexpr int kPerCell = 20;

struct Row {
  double y_mm, x0_mm, dx_mm;
  std::vector<float> z;
};

// One profile through the centre of each grid row, kPerCell samples per cell.
template <class Height>
std::vector<Row> scan(const GridSpec& g, const Height& height_mm, double noise_mm, std::uint64_t seed = 1) {
  std::vector<Row> rows;
  RandomStream random(seed, Purpose::kSensorNoise);
  for (int j = 0; j < g.ny; ++j) {
    const double dx = g.pitch_x_mm / kPerCell;
    Row r{g.y_mm(j), g.x_mm(0) - 0.5 * g.pitch_x_mm + 0.5 * dx, dx, {}};
    for (int n = 0; n < g.nx * kPerCell; ++n)
      r.z.push_back(float(height_mm(r.x0_mm + n * dx, r.y_mm) + noise_mm * random.normal()));
    rows.push_back(r);
  }
  return rows;
}

SurfaceEstimate map_of(const GridSpec& g, const std::vector<Row>& rows, const MapOptions& options = {}) {
  SurfaceMap map(g);
  for (const Row& r : rows) map.add_row(r.y_mm, r.x0_mm, r.dx_mm, r.z);
  return map.estimate(options);
}

double rms_error(const HeightMap& h, double truth) {
  double sum = 0.0;
  for (double v : h.cells) sum += (v - truth) * (v - truth);
  return std::sqrt(sum / double(h.size()));
}

}  // namespace

TEST_CASE("A plane comes back exactly, cell by cell") {
  const auto plane = [](double x, double y) { return 0.1 + 0.02 * x - 0.01 * y; };
  const SurfaceEstimate e = map_of(kGrid, scan(kGrid, plane, 0.0));
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) {
      CHECK(e.height.at(i, j) == Approx(plane(kGrid.x_mm(i), kGrid.y_mm(j))).margin(1e-7));
      CHECK(e.quality.at(i, j) == 0);
    }
  CHECK(e.measured_fraction == 1.0);
}

TEST_CASE("The estimate does not depend on the order of the rows, to the last bit") {
  auto rows = scan(
      kGrid, [](double x, double y) { return 0.05 * x * y; }, 0.001);
  const SurfaceEstimate a = map_of(kGrid, rows);
  std::reverse(rows.begin(), rows.end());
  std::swap(rows[2], rows[6]);
  const SurfaceEstimate b = map_of(kGrid, rows);
  CHECK(a.height == b.height);
  CHECK(a.noise_std_mm == b.noise_std_mm);
}

TEST_CASE("A cell of any number of samples, many of them equal, has the median and the mean of its inliers") {
  const GridSpec one{1, 1, 1.0, 1.0, 0.0, 0.0};
  RandomStream random(3, Purpose::kTest);
  for (std::size_t count = 1; count < 100; ++count) {
    std::vector<float> z;
    for (std::size_t n = 0; n < count; ++n) z.push_back(0.001f * float(int(random.below(9)) - 4));
    SurfaceMap map(one);
    map.add_row(0.0, -0.49, 0.98 / double(count), z);
    std::sort(z.begin(), z.end());
    const double median = 0.5 * (double(z[(count - 1) / 2]) + double(z[count / 2]));
    const double reach = std::max(1e-3, 4.0 * 0.7413 * (double(z[3 * count / 4]) - double(z[count / 4])));
    double sum = 0.0, inliers = 0.0;
    for (const float v : z) {
      if (double(v) < median - reach || double(v) > median + reach) continue;
      sum += double(v);
      inliers += 1.0;
    }
    INFO(count << " samples");
    CHECK(map.estimate({CellStatistic::kMedian}).height.cells[0] == median);
    CHECK(map.estimate({CellStatistic::kInlierMean}).height.cells[0] == sum / inliers);
  }
}

TEST_CASE("Noise of a cell is the noise of a sample over the root of their number") {
  const SurfaceEstimate e = map_of(kGrid, scan(
                                              kGrid, [](double, double) { return 0.2; }, 0.001));
  CHECK(e.noise_std_mm == Approx(0.001 / std::sqrt(double(kPerCell))).epsilon(0.05));
  CHECK(rms_error(e.height, 0.2) == Approx(e.noise_std_mm).epsilon(0.2));
}

TEST_CASE("With spikes and drop-outs the inlier mean beats median and mean") {
  double error[3] = {};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    auto rows = scan(
        kGrid, [](double, double) { return 0.2; }, 0.001, seed);
    RandomStream random(seed, Purpose::kDropout);
    for (Row& r : rows)
      for (float& z : r.z) {
        const double u = random.uniform();
        if (u < 0.005)
          z = std::nanf("");
        else if (u < 0.025)
          z += float(random.uniform(-0.05, 0.05));
      }
    for (const auto s : {CellStatistic::kMean, CellStatistic::kMedian, CellStatistic::kInlierMean})
      error[int(s)] += rms_error(map_of(kGrid, rows, {s, 0.05}).height, 0.2) / 10.0;
  }
  INFO("mean " << error[0] << " median " << error[1] << " inlier mean " << error[2]);
  CHECK(error[2] < error[1]);
  CHECK(error[1] < error[0]);
  CHECK(error[2] < 0.00026);
}

TEST_CASE(
    "Cells and rows without samples are filled from their neighbours and marked, and the rest is untouched") {
  auto rows = scan(
      kGrid, [](double x, double) { return 0.1 * x; }, 0.0);
  rows.erase(rows.begin() + 4);
  for (int n = 3 * kPerCell; n < 4 * kPerCell; ++n) rows[1].z[std::size_t(n)] = std::nanf("");
  const SurfaceEstimate e = map_of(kGrid, rows);
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) {
      const bool open = j == 4 || (i == 3 && j == 1);
      CHECK(int(e.quality.at(i, j)) == (open ? 1 : 0));
      if (i > 0 && i + 1 < kGrid.nx) CHECK(e.height.at(i, j) == Approx(0.1 * kGrid.x_mm(i)).margin(1e-7));
    }
  CHECK(e.measured_fraction == Approx(1.0 - 13.0 / 108.0));
}

TEST_CASE("A wide hole is filled from the rim inwards, and nothing measured is 0 mm with fraction 0") {
  auto rows = scan(
      kGrid, [](double, double) { return 0.3; }, 0.0);
  rows.resize(1);
  const SurfaceEstimate e = map_of(kGrid, rows);
  for (double h : e.height.cells) CHECK(h == Approx(0.3).margin(1e-7));
  const SurfaceEstimate none = map_of(kGrid, {});
  CHECK(none.measured_fraction == 0.0);
  CHECK(none.noise_std_mm == 0.0);
  for (std::size_t c = 0; c < kGrid.size(); ++c) {
    CHECK(none.height.cells[c] == 0.0);
    CHECK(none.quality.cells[c] == 1);
  }
}

TEST_CASE("A spike of one cell is replaced and marked, and the cliff of a part is not") {
  const auto cliff = [](double x, double) { return x > 2.4 ? 0.4 : 0.0; };
  auto rows = scan(kGrid, cliff, 0.0005);
  for (int n = 2 * kPerCell; n < 3 * kPerCell; ++n) rows[5].z[std::size_t(n)] += 0.06f;
  const SurfaceEstimate e = map_of(kGrid, rows);
  CHECK(e.spikes == 1);
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) CHECK(int(e.quality.at(i, j)) == (i == 2 && j == 5 ? 2 : 0));
  CHECK(e.height.at(2, 5) == Approx(0.0).margin(0.001));
  CHECK(e.height.at(11, 5) == Approx(0.4).margin(0.001));
}

TEST_CASE("Samples off the grid are ignored, several lines in one grid row are pooled") {
  SurfaceMap map(kGrid);
  const std::vector<float> low(240, 0.1f), high(240, 0.3f);
  map.add_row(kGrid.y_mm(0) - kGrid.pitch_y_mm, kGrid.x_mm(0), 0.0125, high);
  map.add_row(1e9, kGrid.x_mm(0), 0.0125, high);
  map.add_row(kGrid.y_mm(2) - 0.1, kGrid.x_mm(0) - 50.0, 0.0125, high);
  map.add_row(kGrid.y_mm(2) - 0.1, kGrid.x_mm(0) - 0.125, 0.0125, low);
  map.add_row(kGrid.y_mm(2) + 0.1, kGrid.x_mm(0) - 0.125, 0.0125, high);
  MapOptions mean;
  mean.statistic = CellStatistic::kMean;
  const SurfaceEstimate e = map.estimate(mean);
  CHECK(e.measured_fraction == Approx(12.0 / 108.0));
  CHECK(e.height.at(5, 2) == Approx(0.2).margin(1e-7));
  map.clear();
  CHECK(map.estimate(mean).measured_fraction == 0.0);
}
