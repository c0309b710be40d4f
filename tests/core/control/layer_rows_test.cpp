#include "core/control/mpc/layer/layer_rows.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/deposition/height_change.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

// The arrays that rows are read from, and plain loops over them: every kernel must return the same bytes.
struct Plain {
  std::size_t nx, ny, row;
  RowInk ink;
  std::vector<float> height, bare, error;
  std::vector<std::uint8_t> counts, drops;

  Plain(const StripInstance& in, const DropletPattern& u)
      : nx(std::size_t(in.setup.grid.nx)), ny(std::size_t(in.setup.grid.ny)), row(whole_blocks(nx) + 2) {
    const bool lose = in.setup.border == deposition::Border::kLose;
    const float far = std::numeric_limits<float>::infinity();
    height.assign(row * (ny + 2), lose ? -far : far);
    bare.assign(height.size(), 0.0f);
    counts.assign(height.size(), 0);
    drops.assign(height.size(), 0);
    ink.drop_mm = float(in.setup.model.layer_height_mm());
    for (const deposition::Link& link : deposition::links_of(deposition::stencil_of(in.setup.model))) {
      const std::size_t k = link.dx != 0 && link.dy != 0;
      ink.w_mm[k] = float(link.w_mm);
      ink.slope[k] = float(link.slope);
      ink.beyond_mm[k] = lose ? ink.w_mm[k] : 0.0f;
    }
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i) {
        const std::size_t c = in.setup.grid.index(int(i), int(j)), p = at(i, j);
        height[p] = float(in.height.cells[c]);
        counts[p] = in.setup.mask.cells[c];
        if (!counts[p]) continue;
        bare[p] = float(in.height.cells[c] - in.setup.target.cells[c]);
        drops[p] = u.cells[c];
      }
    error = errors();
  }
  std::size_t at(std::size_t i, std::size_t j) const { return (j + 1) * row + i + 1; }
  std::size_t near(std::size_t p, std::size_t q) const { return p + (q / 3) * row + q % 3 - row - 1; }
  RowCells cells(std::size_t j) const {
    const std::size_t p = at(0, j);
    return {&height[p], &bare[p], &error[p], &counts[p], &drops[p], std::ptrdiff_t(row)};
  }
  float gives(std::size_t p, std::size_t q) const {  // clamp(w + slope (H_p - H_q), 0, w)
    const std::size_t k = q % 2 == 0;
    float x = ink.w_mm[k] + ink.slope[k] * (height[p] - height[near(p, q)]);
    x = x < ink.w_mm[k] ? x : ink.w_mm[k];
    return x > 0.0f ? x : 0.0f;
  }
  std::vector<float> errors() const {
    std::vector<float> out(height.size(), 0.0f);
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i) {
        const std::size_t p = at(i, j);
        float sum = bare[p];
        for (std::size_t q = 0; q < 9; ++q) {
          const std::size_t from = near(p, q);
          if (!drops[from]) continue;
          float own = ink.drop_mm;
          for (std::size_t n = 0; n < 9 && q == 4; ++n)
            if (n != 4) own -= gives(p, n);
          sum += q == 4 ? own : gives(from, 8 - q);
        }
        if (counts[p]) out[p] = sum;
      }
    return out;
  }
};

Plain random_rows(std::uint64_t seed, int nx, int ny) {
  StripInstance in = random_instance(seed, nx, ny, false);
  RandomStream random(seed, Purpose::kInstance);
  if (seed % 3 == 0) in.setup.mask = Mask(in.setup.grid, 1);
  if (seed % 7 == 0) in.setup.model.h2_mm = in.setup.model.h3_mm = 0.0;
  return Plain(in, random_drops(in, random));
}

}  // namespace

TEST_CASE(
    "rows by vectors give the bytes of plain loops, whatever instructions the processor has, for any size, "
    "mask and border") {
  REQUIRE(!layer_row_kernels().empty());
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const bool wide = seed % 40 == 0;
    const Plain rows = random_rows(seed,
                                   seed == 1 ? 1
                                   : wide    ? 1000 + int(random.below(100))
                                             : 1 + int(random.below(41)),
                                   seed == 1 ? 1 : 1 + int(random.below(wide ? 4 : 40)));
    for (const LayerRowKernels& kernels : layer_row_kernels()) {
      INFO(kernels.name << ", " << rows.nx << " x " << rows.ny << ", seed " << seed);
      std::vector<float> errors(rows.height.size(), 0.0f);
      kernels.errors(rows.cells(0), rows.ink, rows.nx, rows.ny, errors.data() + rows.at(0, 0));
      REQUIRE(errors == rows.error);
    }
  }
}

TEST_CASE("a layer problem refreshed by rows has the errors that its droplets leave one by one") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const StripInstance in = random_instance(seed, 1 + int(seed * 7 % 37), 1 + int(seed * 5 % 23), false);
    RandomStream random(seed, Purpose::kInstance);
    const DropletPattern u = random_drops(in, random);
    LayerProblem one(in.setup, in.height, {}), all = one;
    for (int j = 0; j < one.ny(); ++j)
      for (int i = 0; i < one.nx(); ++i) one.set_drop(i, j, u.at(i, j));
    all.set_drops(u);
    for (int j = 0; j < one.ny(); ++j)
      for (int i = 0; i < one.nx(); ++i) REQUIRE(all.error_mm(i, j) == one.error_mm(i, j));
  }
}
