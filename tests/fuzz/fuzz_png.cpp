// Any bytes as a grey PNG picture, with the checksums of its chunks made true: a picture of its header's size
// with values up to white, or a PngError.
#include "core/grid/png.h"

#include <vector>

#include "tests/fuzz/png_bytes.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::uint8_t> file = mended_png(data, size);
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
