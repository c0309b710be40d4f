// The loops over pixels with and without AVX2 against each other and against plain arithmetic.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/grid/random.h"
#include "core/vision/illumination_kernels.h"

using namespace firn;
using namespace firn::vision;

namespace {

struct KernelResult {
  std::vector<std::uint32_t> sum;
  std::vector<std::uint16_t> low, high, least, greatest;
  std::vector<float> mean, ground;
  ContrastSums sums;
  std::int32_t smallest = 0, largest = 0, count = 0;
  bool deeper = false;
};

KernelResult run_kernels(const IlluminationKernels& k, int blocks, const std::vector<std::uint16_t>& pixels) {
  const std::size_t n = std::size_t(blocks), w = 4 * n;
  KernelResult r;
  r.sum.resize(w);
  r.low.resize(w);
  r.high.resize(w);
  r.least.resize(n);
  r.greatest.resize(n);
  r.mean.resize(n);
  r.ground.resize(n);
  k.add_rows(pixels.data(), w, int(w), r.sum.data(), r.low.data(), r.high.data());
  k.join_blocks(blocks, r.sum.data(), r.low.data(), r.high.data(), r.mean.data(), r.least.data(),
                r.greatest.data());
  std::vector<double> u(n);
  for (std::size_t i = 0; i < n; ++i) u[i] = (double(i) - 7.3) / 41.0;
  k.cubic_row(u.data(), blocks, {31000.0, 9000.0, -21000.0, 5000.0}, 40000.0, 4000.0, r.mean.data(),
              r.ground.data(), r.sums);
  k.add_line(u.data(), blocks, 0.31, 17.7, r.ground.data());
  std::vector<std::int32_t> levels(n);
  k.scale_by_16(r.mean.data(), blocks, levels.data());
  k.extremes(levels.data(), blocks, r.smallest, r.largest);
  r.count = k.count_up_to(levels.data(), blocks, 16 * 30000);
  r.deeper = k.any_deeper(r.ground.data(), r.mean.data(), blocks, 25000.0F);
  return r;
}

std::vector<std::uint16_t> four_rows(RandomStream& random, int blocks) {
  std::vector<std::uint16_t> pixels(16 * std::size_t(blocks));
  for (std::uint16_t& p : pixels) p = std::uint16_t(random.below(65536));
  return pixels;
}

}  // namespace

TEST_CASE("The loops over pixels give the same bytes with wide vectors and without, at any length",
          "[seeded]") {
  RandomStream random(4, Purpose::kTest);
  for (int blocks = 1; blocks < 70; ++blocks) {
    CAPTURE(blocks);
    const std::vector<std::uint16_t> pixels = four_rows(random, blocks);
    const KernelResult a = run_kernels(illumination_kernels(false), blocks, pixels),
                       b = run_kernels(illumination_kernels(has_avx2()), blocks, pixels);
    CHECK((a.mean == b.mean && a.least == b.least && a.greatest == b.greatest));
    CHECK(a.ground == b.ground);
    CHECK((a.sums.darker == b.sums.darker && a.sums.brighter == b.sums.brighter));
    CHECK((a.smallest == b.smallest && a.largest == b.largest && a.count == b.count && a.deeper == b.deeper));
  }
}

TEST_CASE("Means and extremes of blocks, levels and contrasts are those of plain arithmetic", "[seeded]") {
  RandomStream random(5, Purpose::kTest);
  constexpr int kBlocks = 37;
  const std::vector<std::uint16_t> pixels = four_rows(random, kBlocks);
  const KernelResult r = run_kernels(illumination_kernels(), kBlocks, pixels);
  double darker = 0.0, brighter = 0.0;
  int count = 0;
  for (int b = 0; b < kBlocks; ++b) {
    int sum = 0, least = 65535, greatest = 0;
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) {
        const int p = pixels[std::size_t(y * 4 * kBlocks + 4 * b + x)];
        sum += p;
        least = std::min(least, p);
        greatest = std::max(greatest, p);
      }
    CHECK((r.mean[std::size_t(b)] == float(sum / 16.0) && r.least[std::size_t(b)] == least &&
           r.greatest[std::size_t(b)] == greatest));
    count += sum <= 16 * 30000;
    const double u = (b - 7.3) / 41.0;
    const double g = std::clamp(31000.0 + u * (9000.0 + u * (-21000.0 + u * 5000.0)), 0.0, 40000.0);
    CHECK(double(r.ground[std::size_t(b)]) == Approx(g + 0.31 + u * 17.7).epsilon(1e-6));
    const double c = g - sum / 16.0;
    if (c > 4000.0) darker += c * c;
    if (-c > 4000.0) brighter += c * c;
  }
  CHECK(r.sums.darker == Approx(darker));
  CHECK(r.sums.brighter == Approx(brighter));
  CHECK(r.count == count);
}
