#include "core/control/lines/line_growth.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::control;

namespace {

constexpr double kGrowthSigma_mm = 0.032, kGrowthStd_mm = 0.0005;
constexpr std::size_t kGrowthStations = 20;

/// Lines of layers that hold these shares of the planned section, as a camera of `dimmed` contrast sees them.
std::vector<GrowthShare> grown(const std::vector<double>& shares, double section_mm2, double depth_mm,
                               double sigma_mm = kGrowthSigma_mm) {
  LineGrowth growth(VisibleWidth(kGrowthSigma_mm, depth_mm));
  const VisibleWidth nature(sigma_mm, depth_mm);
  constexpr double kDimmed = 0.9;
  RandomStream random(7, Purpose::kSensorNoise);
  std::vector<GrowthShare> told;
  double ink = 0.0;
  for (std::size_t n = 0; n < shares.size(); ++n) {
    ink += shares[n] * section_mm2;
    std::vector<SeenLine> seen;
    for (std::size_t s = 0; s < kGrowthStations; ++s)
      seen.push_back({kDimmed * nature.contrast(ink), nature.width_mm(ink) + kGrowthStd_mm * random.normal(),
                      kGrowthStd_mm});
    growth.plan(std::int32_t(n) + 1, std::vector<double>(kGrowthStations, section_mm2));
    told.push_back(growth.look(std::int32_t(n) + 1, seen));
  }
  return told;
}

}  // namespace

TEST_CASE("Growth of thin and of thick ink is that of the planned ink, and none where a layer brought none") {
  for (const double depth_mm : {0.0005, 0.002, 0.05})
    for (const double sigma_mm : {0.8 * kGrowthSigma_mm, 1.2 * kGrowthSigma_mm}) {
      CAPTURE(depth_mm, sigma_mm);
      const std::vector<GrowthShare> g = grown({1, 1, 1, 0, 1}, 3.3e-4, depth_mm, sigma_mm);
      CHECK_FALSE(g[0].resolved());
      for (const std::size_t layer : {1, 2}) {
        CHECK(g[layer].resolved());
        CHECK(g[layer].share == Approx(1.0).margin(0.3));
      }
      CHECK(g[3].resolved());
      CHECK(g[3].share == Approx(0.0).margin(0.2));
      CHECK(g[4].share > 0.7);
    }
}

TEST_CASE("Growth too slow for one layer's pictures adds up, and layers without ink are found") {
  std::vector<double> shares(40, 1.0);
  for (std::size_t n = 24; n < shares.size(); ++n) shares[n] = 0.0;
  const std::vector<GrowthShare> g = grown(shares, 3.3e-4, 0.002);
  int unresolved = 0;
  bool found = false;
  for (std::size_t n = 1; n < shares.size(); ++n) {
    CAPTURE(n);
    unresolved += !g[n].resolved();
    if (n < 24 && g[n].resolved()) CHECK(g[n].share > 0.5);
    found = found || (n >= 24 && g[n].resolved() && g[n].share < 0.3);
  }
  CHECK(unresolved > 0);
  CHECK(found);
}

TEST_CASE("A second look at a layer starts from the look before it, and a station not seen says nothing") {
  LineGrowth growth(VisibleWidth(kGrowthSigma_mm, 0.002));
  const VisibleWidth nature(kGrowthSigma_mm, 0.002);
  const double nan = std::nan("");
  const auto line = [&](double ink) { return SeenLine{nature.contrast(ink), nature.width_mm(ink), 0.0001}; };
  growth.plan(1, {3e-4, 3e-4});
  growth.look(1, std::vector<SeenLine>{line(3e-4), line(3e-4)});
  growth.plan(2, {3e-4, 3e-4});
  CHECK(growth.look(2, std::vector<SeenLine>{line(3e-4), line(3e-4)}).share == Approx(0.0).margin(1e-9));
  CHECK(growth.look(2, std::vector<SeenLine>{{nan, nan, nan}, line(6e-4)}).share == Approx(1.0));
  CHECK_FALSE(growth.look(2, std::vector<SeenLine>(2, {nan, nan, nan})).resolved());
}
