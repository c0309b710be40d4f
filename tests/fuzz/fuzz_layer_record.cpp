// Any text as a layer-wise record: a table of points. Input: u8 whether pitches are given, the text.
#include <cmath>

#include "files/layer_record.h"
#include "files/usage_error.h"
#include "tests/fuzz/require.h"

using namespace firn;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  LayerRecordOptions options;
  if (data[0] & 1) options.pitch_x_mm = options.pitch_y_mm = 0.5;
  if (data[0] & 2) options.unit = "um";
  try {
    const LayerRecord r =
        read_layer_table({reinterpret_cast<const char*>(data + 1), size - 1}, "fuzz.csv", options);
    fuzz::require(!r.heights.empty(), "a record has a ground");
    std::int64_t points = 0;
    for (const HeightMap& map : r.heights) {
      fuzz::require(map.spec == r.grid, "all maps have the record's grid");
      for (const double h : map.cells) {
        fuzz::require(!std::isinf(h), "no height is infinite");
        points += !std::isnan(h);
      }
    }
    fuzz::require(points >= r.points && r.missing >= 0, "heights are counted");
  } catch (const UsageError&) {
  }
  return 0;
}
