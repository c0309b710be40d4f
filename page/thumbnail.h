// thumbnail_png draws the error of a run's last measured map as a small picture: blue is too low, orange too
// high, and the full colour is an error of the run's tolerance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/grid/grid.h"

namespace firn {
struct Product;
}

namespace firn::page {

inline constexpr int kThumbnailPixels = 96;  ///< longer side; the page shows it at half of this

/// Returns the map with at most kThumbnailPixels cells on its longer side, in the proportions of its
/// millimetres: each cell is the mean of the seen cells below it, NaN without one.
HeightMap small_map(const HeightMap& map);

/// Returns the bytes of a PNG; empty: the run has no map or no target, its records cannot be read, or they
/// have more than kMaxThumbnailBytes plain bytes.
std::string thumbnail_png(const Product& product, const std::filesystem::path& run);

/// Plain bytes of the log, or of the mapper's write-ahead file without one: reading takes 12 ms of a core per
/// MB.
inline constexpr std::uint64_t kMaxThumbnailBytes = std::uint64_t(64) << 20;

}  // namespace firn::page
