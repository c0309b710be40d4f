// Any bytes as a grey PNG picture, with the checksums of its chunks made true: a picture of its header's size
// with values up to white, or a PngError.
#include "core/grid/png.h"

#include <vector>

#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

std::uint32_t crc32(const std::uint8_t* data, std::size_t size) {
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t n = 0; n < size; ++n) {
    crc ^= data[n];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

std::uint32_t big_endian(const std::uint8_t* at) {
  return std::uint32_t(at[0]) << 24 | std::uint32_t(at[1]) << 16 | std::uint32_t(at[2]) << 8 | at[3];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> file(data, data + size);
  for (std::size_t at = 8; at + 12 <= size;) {
    const std::size_t n = big_endian(&file[at]);
    if (n > size - at - 12) break;
    const std::uint32_t crc = crc32(&file[at + 4], n + 4);
    for (std::size_t k = 0; k < 4; ++k) file[at + 8 + n + k] = std::uint8_t(crc >> (24 - 8 * k));
    at += 12 + n;
  }
  try {
    const auto bytes = as_bytes(file.data(), file.size());
    const PngHeader header = png_header(bytes);
    if (std::uint64_t(header.width) * header.height > 1u << 16) return 0;  // time goes into memory alone
    const GreyPicture p = read_grey_png(bytes);
    require(std::uint32_t(p.width) == header.width && std::uint32_t(p.height) == header.height,
            "a picture has its header's size");
    require(p.pixels.size() == std::size_t(p.width) * std::size_t(p.height), "each pixel has a value");
    for (const double v : p.pixels) require(v >= 0.0 && v <= p.white, "values lie between black and white");
  } catch (const PngError&) {
  }
  return 0;
}
