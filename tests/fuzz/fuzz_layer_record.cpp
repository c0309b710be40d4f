// Any bytes as a layer-wise record: a table of points, or the two layers of a folder. Input: u8 of flags
// (pitches are given, a unit is given, a folder, its first layer is .npy, with inputs, no labels), the text.
// Layers are halves of it.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "files/layer_record.h"
#include "files/usage_error.h"
#include "tests/fuzz/require.h"
#include "tests/support/temp_folder.h"

using namespace firn;

namespace {

LayerRecord read_folder(std::string_view text, bool npy, bool inputs, const LayerRecordOptions& options) {
  static const test::TempFolder made;
  const std::filesystem::path folder = made.path() / (npy ? "npy" : "csv");
  std::filesystem::create_directories(folder);
  std::ofstream(folder / (npy ? "1.npy" : "1.csv"), std::ios::binary) << text.substr(0, text.size() / 2);
  std::ofstream(folder / "2.csv", std::ios::binary) << text.substr(text.size() / 2);
  return read_layer_files({.heights = folder, .inputs = inputs ? folder : std::filesystem::path()}, options);
}

void require_sound(const LayerRecord& r) {
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
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  LayerRecordOptions options;
  if (data[0] & 1) options.pitch_x_mm = options.pitch_y_mm = 0.5;
  if (data[0] & 2) options.unit = "um";
  if (data[0] & 32) options.labels = MatrixLabels::kNone;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    require_sound(data[0] & 4 ? read_folder(text, data[0] & 8, data[0] & 16, options)
                              : read_layer_table(text, "fuzz.csv", options));
  } catch (const UsageError&) {
  }
  return 0;
}
