// Encodes a map of values on a grid as the page reads it: "FMAP", u16 version = 1, u16 surface, u32 layer,
// u32 nx, u32 ny, u32 flags, f64 time [s], then nx * ny f32, row y = 0 first, all little endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"

namespace firn::page {

enum class Surface : std::uint16_t { kMeasured, kTarget, kError, kPlanned, kPredicted, kTruth };
inline constexpr int kSurfaces = 6;

/// Returns the surface of a word: "measured", "target", "error", "planned", "predicted", "truth".
std::optional<Surface> surface_of(std::string_view word);
std::string_view word_of(Surface surface);

inline constexpr std::uint32_t kCounts = 1;   ///< values are droplets
inline constexpr std::uint32_t kPart = 2;     ///< the map is being measured
inline constexpr std::uint32_t kFactors = 4;  ///< values are relative to the nominal
inline constexpr std::uint32_t kRows = 8;     ///< some rows alone, each behind its number as u32
inline constexpr std::size_t kMapHeaderBytes = 32;

/// @param values of the cells in um (droplets, factors by `flags`); NaN: not seen
std::vector<std::byte> encode_map(Surface surface, int layer, const GridSpec& grid, std::uint32_t flags,
                                  double t_s, std::span<const float> values);

/// Returns the rows whose `stamps` are above `since`, of a map that the reader has up to there. Heights in
/// mm.
std::vector<std::byte> encode_rows(Surface surface, int layer, const HeightMap& height, std::uint32_t flags,
                                   double t_s, std::span<const std::uint64_t> stamps, std::uint64_t since);

/// Returns a map of heights [mm].
std::vector<std::byte> encode_heights(Surface surface, int layer, const HeightMap& height,
                                      std::uint32_t flags, double t_s);

}  // namespace firn::page
