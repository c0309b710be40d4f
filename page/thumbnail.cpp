#include "page/thumbnail.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "files/record/file.h"
#include "files/record/packed.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "page/run_maps.h"
#include "print/labs/print_lab.h"
#include "print/labs/product.h"
#include "report/draw/heat_map.h"
#include "runs/folder/config_change.h"
#include "runs/folder/documents.h"
#include "runs/read/run_reader.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;

constexpr double kUmPerMm = 1e3;
constexpr double kUntoldRms = 3.0;  // full colour of a run without a tolerance, in RMS of its error

std::uint64_t plain_bytes(const fs::path& file) {
  if (!fs::exists(file)) return 0;
  const record::MappedFile mapped(file, record::MappedFile::Packed::kAsIs);
  return record::declared_bytes(mapped.bytes()).value_or(mapped.bytes().size());
}

std::uint64_t bytes_to_read(const fs::path& run) {
  const RunPaths paths(run);
  if (const std::uint64_t log = plain_bytes(paths.log_path())) return log;
  return plain_bytes(paths.wal_path(info(find_channel(channels::kHeightMap.name)->publisher).name));
}

double tolerance_um(const Product& product, const Experiment& experiment, const fs::path& run) {
  const fs::path file = RunPaths(run).result_path();
  if (fs::exists(file))
    if (const auto told = runs::parse_result(read_file(file), RunPaths::kResult).tolerance_um) return *told;
  return print_lab(product, experiment).tolerance_um(experiment);
}

double rms_um(const HeightMap& error) {
  double sum = 0.0, cells = 0.0;
  for (const double mm : error.cells) {
    if (!std::isfinite(mm)) continue;
    sum += mm * mm;
    cells += 1.0;
  }
  return cells > 0.0 ? std::sqrt(sum / cells) * kUmPerMm : 0.0;
}

std::optional<HeightMap> last_error(const fs::path& run, const Experiment& experiment,
                                    runs::RunReader& reader) {
  const RunPaths paths(run);
  const fs::path file = paths.provenance_path();
  std::map<std::string, fs::path> inputs;
  for (const auto& [role, sha] : runs::parse_provenance(read_file(file), file.string()).inputs)
    inputs[role] = paths.input_path(sha);
  RunMaps maps(run, experiment, inputs, [&](const runs::Place& place) { return reader.read(place); });
  reader.poll([&](std::string_view channel, std::span<const std::byte> message, runs::Place place) {
    maps.take(channel, message, place);
  });
  const auto layer = maps.newest_layer();
  return layer ? maps.error(*layer) : std::nullopt;
}

}  // namespace

HeightMap small_map(const HeightMap& map) {
  const GridSpec& g = map.spec;
  const double width_mm = g.nx * g.pitch_x_mm, height_mm = g.ny * g.pitch_y_mm;
  const double pixel_mm = std::max(width_mm, height_mm) / kThumbnailPixels;
  GridSpec small = g;
  small.nx = std::max(1, int(std::lround(width_mm / pixel_mm)));
  small.ny = std::max(1, int(std::lround(height_mm / pixel_mm)));
  small.pitch_x_mm = width_mm / small.nx;
  small.pitch_y_mm = height_mm / small.ny;
  HeightMap out(small, kNotMeasured);
  const auto cells_of = [](int pixel, int pixels, int cells) {
    const int from = int(std::int64_t(pixel) * cells / pixels);
    const int to = int((std::int64_t(pixel + 1) * cells + pixels - 1) / pixels);
    return std::pair(from, to);
  };
  for (int j = 0; j < small.ny; ++j)
    for (int i = 0; i < small.nx; ++i) {
      const auto [left, right] = cells_of(i, small.nx, g.nx);
      const auto [low, high] = cells_of(j, small.ny, g.ny);
      double sum = 0.0, seen = 0.0;
      for (int y = low; y < high; ++y)
        for (int x = left; x < right; ++x)
          if (const double mm = map.at(x, y); std::isfinite(mm)) {
            sum += mm;
            seen += 1.0;
          }
      if (seen > 0.0) out.at(i, j) = sum / seen;
    }
  return out;
}

std::string thumbnail_png(const Product& product, const fs::path& run) try {
  if (bytes_to_read(run) > kMaxThumbnailBytes) return "";
  runs::RunReader reader(run, {std::string(channels::kHeightMap.name), std::string(channels::kRunEnd.name)},
                         runs::RunReader::Source::kLog);
  std::string recorded = reader.config();
  if (recorded.empty()) recorded = runs::recorded_config(run);
  const fs::path file = RunPaths(run).experiment_path();
  const Experiment experiment =
      parse_recorded_experiment(recorded.empty() ? read_file(file) : recorded, file.string());
  const auto error = last_error(run, experiment, reader);
  if (!error) return "";
  double full_um = tolerance_um(product, experiment, run);
  if (!(full_um > 0.0)) full_um = kUntoldRms * rms_um(*error);
  if (!(full_um > 0.0)) return "";
  const report::HeatScale scale{-full_um, full_um, report::ColorMap::kDiverging};
  const std::vector<std::byte> png = report::png_of(report::colour_cells(small_map(*error), scale));
  return {reinterpret_cast<const char*>(png.data()), png.size()};
} catch (const std::exception&) {  // the run's own page names what is wrong with it
  return "";
}

}  // namespace firn::page
