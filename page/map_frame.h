// Encodes a map of values on a grid as the page reads it: "FMAP", u16 version, u16 surface, u32 layer,
// u32 nx, u32 ny, u32 flags, f64 time [s], then nx * ny f32, row y = 0 first, all little endian. With
// kMapPlaces nx * ny x and as many y follow: where in its cell each cell's droplets land, in shares of the
// pitch from the middle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"
#include "firn/page_protocol.h"

namespace firn::page {

/// Returns the surface of a word of protocol.table.
std::optional<Surface> surface_of(std::string_view word);
std::string_view word_of(Surface surface);

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
