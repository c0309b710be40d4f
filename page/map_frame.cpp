#include "page/map_frame.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>

namespace firn::page {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are little endian");

}  // namespace

std::optional<Surface> surface_of(std::string_view word) {
  const auto found = std::ranges::find(kSurfaceWords, word);
  if (found == std::end(kSurfaceWords)) return std::nullopt;
  return Surface(found - std::begin(kSurfaceWords));
}

std::string_view word_of(Surface surface) { return kSurfaceWords[std::size_t(surface)]; }

std::vector<std::byte> encode_map(Surface surface, int layer, const GridSpec& grid, std::uint32_t flags,
                                  double t_s, std::span<const float> values) {
  std::vector<std::byte> frame(kMapHeaderBytes + values.size_bytes());
  std::byte* at = frame.data();
  const auto put = [&at](const auto& value) {
    std::memcpy(at, &value, sizeof value);
    at += sizeof value;
  };
  std::memcpy(at, "FMAP", 4);
  at += 4;
  put(std::uint16_t{kMapVersion});
  put(std::uint16_t(surface));
  put(std::uint32_t(layer));
  put(std::uint32_t(grid.nx));
  put(std::uint32_t(grid.ny));
  put(flags);
  put(t_s);
  if (!values.empty()) std::memcpy(at, values.data(), values.size_bytes());
  return frame;
}

std::vector<std::byte> encode_rows(Surface surface, int layer, const HeightMap& height, std::uint32_t flags,
                                   double t_s, std::span<const std::uint64_t> stamps, std::uint64_t since) {
  std::vector<std::byte> frame = encode_map(surface, layer, height.spec, flags | kMapRows, t_s, {});
  const std::size_t nx = std::size_t(height.spec.nx);
  std::vector<float> values(nx);
  for (std::size_t j = 0; j < stamps.size(); ++j) {
    if (stamps[j] <= since) continue;
    const std::uint32_t number = std::uint32_t(j);
    std::transform(height.cells.begin() + std::ptrdiff_t(j * nx),
                   height.cells.begin() + std::ptrdiff_t((j + 1) * nx), values.begin(),
                   [](double mm) { return float(mm * 1e3); });
    for (const auto bytes : {std::as_bytes(std::span(&number, 1)), std::as_bytes(std::span(values))})
      frame.insert(frame.end(), bytes.begin(), bytes.end());
  }
  return frame;
}

std::vector<std::byte> encode_heights(Surface surface, int layer, const HeightMap& height,
                                      std::uint32_t flags, double t_s) {
  std::vector<std::byte> frame = encode_map(surface, layer, height.spec, flags, t_s, {});
  frame.resize(kMapHeaderBytes + height.size() * sizeof(float));
  std::byte* at = frame.data() + kMapHeaderBytes;
  for (const double mm : height.cells) {
    const float um = float(mm * 1e3);
    std::memcpy(at, &um, sizeof um);
    at += sizeof um;
  }
  return frame;
}

}  // namespace firn::page
