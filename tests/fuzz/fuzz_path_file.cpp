// Any bytes as a path file, as one layer of it, and as the paths of a run: the first byte chooses.
#include <cstdlib>

#include "core/slice/paths/print_paths.h"
#include "files/path/layer_file.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

void check(const slice::LayerPaths& layer) {
  require(layer.info.size() == layer.lines.size(), "each line has its info");
  for (const geometry::Point& p : layer.lines.points)
    require(std::abs(p.x) <= slice::kMaxPathUnits && std::abs(p.y) <= slice::kMaxPathUnits,
            "coordinates keep their limit");
  for (std::size_t n = 0; n < layer.lines.size(); ++n) require(!layer.lines[n].empty(), "lines have points");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const auto bytes = as_bytes(data + 1, size - 1);
  try {
    if (data[0] % 3 == 2) {
      const slice::PrintPaths paths = slice::decode_print_paths(bytes);
      for (const slice::LayerPaths& layer : paths.layers) check(layer);
      const std::vector<std::byte> again = slice::encode(paths);
      require(slice::encode(slice::decode_print_paths(again)) == again,
              "what was read can be written and read again");
    } else if (data[0] % 3) {
      const slice::PathFileHead head{"fuzz", 1, {{"part", "water"}, {"scaffold", "scaffold"}}, "laser", ""};
      const slice::LayerPaths layer = slice::decode_layer_paths(bytes, head);
      check(layer);
      require(slice::decode_layer_paths(slice::encode(layer), head) == layer,
              "what was read can be written and read again");
    } else {
      LayerReader reader(bytes);
      while (const auto layer = reader.next()) check(*layer);
    }
  } catch (const FormatError&) {
  }
  return 0;
}
