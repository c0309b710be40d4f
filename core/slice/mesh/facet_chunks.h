// for_chunks() visits facets in chunks: concurrently within a wave and wave after wave, so that a mapped file
// need not remain in memory.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/grid/parallel.h"
#include "core/slice/mesh/facets.h"

namespace firn::slice {

inline constexpr std::size_t kChunkFacets = 1 << 16;
inline constexpr int kWaveChunks = 8;

inline int chunk_count(const FacetView& facets) {
  return int((facets.size() + kChunkFacets - 1) / kChunkFacets);
}

enum class Pass {
  kFirst,  ///< from the first wave to the last; others follow
  kLast,   ///< from the last wave to the first: the chunks read last are still in memory
};

/// Calls body(chunk, first facet, end) for all chunks; chunks of the same `lane` (chunk % kWaveChunks) never
/// run at the same time.
template <class Body>
void for_chunks(const FacetView& facets, Pass pass, const ParallelFor& parallel, const Body& body) {
  const int chunks = chunk_count(facets), waves = (chunks + kWaveChunks - 1) / kWaveChunks;
  for (int n = 0; n < waves; ++n) {
    const int wave = kWaveChunks * (pass == Pass::kLast ? waves - 1 - n : n);
    const int behind = std::min(chunks, wave + kWaveChunks);
    parallel(behind - wave, [&](int lane) {
      const std::size_t first = std::size_t(wave + lane) * kChunkFacets;
      body(wave + lane, first, std::min(first + kChunkFacets, facets.size()));
    });
    if (facets.done_with)
      facets.done_with(std::size_t(wave) * kChunkFacets,
                       std::min(std::size_t(behind) * kChunkFacets, facets.size()), pass != Pass::kLast);
  }
}

}  // namespace firn::slice
