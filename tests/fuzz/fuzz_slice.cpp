// Slices any facets at all: the first bytes choose options, the rest are corners on a coarse lattice (where
// nearly everything meets) or floats as they come. The outlines cross nowhere and do not depend on the order
// of the facets.
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "tests/core/slice/oracles.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

std::vector<float> corners(const std::uint8_t* data, std::size_t size, bool as_floats) {
  std::vector<float> out;
  if (as_floats) {
    out.resize(size / 4);
    if (!out.empty()) std::memcpy(out.data(), data, 4 * out.size());
  } else {
    for (std::size_t n = 0; n < size; ++n)
      out.push_back(float(data[n] % 16) * (n % 3 == 2 ? 0.37f : 0.0003f));
  }
  out.resize(std::min<std::size_t>(out.size() / 9, 60) * 9);
  return out;
}

slice::Sliced sliced(const std::vector<float>& soup, const slice::SliceOptions& options) {
  slice::FacetView view;
  view.soup = reinterpret_cast<const std::byte*>(soup.data());
  view.stride = 36;
  view.soup_facets = soup.size() / 9;
  return slice::slice(view, {}, options, serially);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  slice::SliceOptions options;
  options.layer_height_mm = 0.5 + data[0] % 4;
  options.chord_tolerance_mm = data[0] & 16 ? 0.0003 : 0.0;
  options.closing_gap_mm = data[0] & 32 ? 0.001 : 0.0;
  std::vector<float> soup = corners(data + 2, size - 2, data[1] % 2);
  if (soup.empty()) return 0;
  try {
    const slice::Sliced once = sliced(soup, options);
    if (once.layers.size() > 2'000) return 0;
    for (const geometry::Region& layer : once.layers) {
      require(test::crossing_by_all_pairs(layer).empty(), "no ring crosses");
      require(geometry::canonical(layer) == layer, "rings begin at their smallest point, in order");
    }
    for (std::size_t n = 0, m = soup.size() - 9; n < m; n += 9, m -= 9)  // the other way round
      std::swap_ranges(soup.begin() + std::ptrdiff_t(n), soup.begin() + std::ptrdiff_t(n) + 9,
                       soup.begin() + std::ptrdiff_t(m));
    require(sliced(soup, options).layers == once.layers, "the order of facets changes nothing");
  } catch (const std::invalid_argument&) {  // a part larger than the grid, too many layers
  }
  return 0;
}
