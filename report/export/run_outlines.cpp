#include "report/export/run_outlines.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/npy.h"
#include "core/grid/outline.h"
#include "files/record/event_format.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "firn/height_map_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "runs/read/run_messages.h"
#include "runs/read/truth.h"

namespace firn::report {
namespace {

using schema::Kind;

struct Row {
  std::int32_t layer = 0;
  bool truth = false;
  OutlineStats outline;
};

std::optional<std::string> input_of(const runs::ProvenanceDocument& p, const std::filesystem::path& run,
                                    std::string_view role) {
  const auto found = std::ranges::find(p.inputs, role, [](const auto& input) { return input.first; });
  if (found == p.inputs.end()) return std::nullopt;
  return RunPaths(run).input_path(found->second).string();
}

Table outline_table(const std::string& prefix) {
  Table table{prefix + "metrics/OUTLINE",
              "How well the part keeps within its outline, of each measured map and each true surface, as "
              "means of the grid's cells.",
              {{"layer", Kind::kInt32, Shape::kOne, "1", "Layers deposited so far.", ""},
               {"is_true", Kind::kByte, Shape::kOne, "1", "Of the measured map, or of the true surface.",
                "measured = 0, true = 1"}},
              std::nullopt};
  for (const OutlineMetric& m : kOutlineMetrics)
    table.columns.push_back({std::string(m.name), Kind::kDouble, Shape::kOne, std::string(m.unit),
                             "The " + std::string(m.meaning) + "; NaN: cannot be told.", ""});
  return table;
}

void write(const Row& row, std::size_t table, TableSink& sink) {
  std::vector<std::byte> bytes(5 + 8 * std::size(kOutlineMetrics));
  record::put_big32(bytes.data(), std::uint32_t(row.layer));
  bytes[4] = std::byte(row.truth);
  std::vector<Cell> cells{{std::span(bytes).first(4), {}}, {std::span(bytes).subspan(4, 1), {}}};
  std::size_t at = 5;
  for (const OutlineMetric& m : kOutlineMetrics) {
    record::put_big64(bytes.data() + at, std::bit_cast<std::uint64_t>(row.outline.*m.value * m.factor));
    cells.push_back({std::span(bytes).subspan(at, 8), {}});
    at += 8;
  }
  sink.row(table, cells);
}

}  // namespace

void write_outlines(const std::filesystem::path& run, const runs::ProvenanceDocument& provenance,
                    const std::string& prefix, TableSink& sink) {
  const auto target_file = input_of(provenance, run, "target"), mask_file = input_of(provenance, run, "mask");
  if (!target_file || !mask_file || input_of(provenance, run, "job")) return;  // a line has no outline
  const record::MappedFile target_bytes(*target_file, record::MappedFile::Packed::kAsIs),
      mask_bytes(*mask_file, record::MappedFile::Packed::kAsIs);
  std::vector<Row> rows;
  const auto add = [&](std::int32_t layer, bool truth, const HeightMap& height) {
    const NpyShape shape = npy_shape(target_bytes.bytes(), *target_file);
    if (layer == 0 || height.spec.nx != shape.nx || height.spec.ny != shape.ny) return;
    rows.push_back(
        {layer, truth,
         outline_stats(height, height_map_from_npy(target_bytes.bytes(), height.spec, *target_file),
                       mask_from_npy(mask_bytes.bytes(), height.spec, *mask_file))});
  };
  const std::string maps(channels::kHeightMap.name);
  runs::RunMessages(run, {maps}).each<height_map_t>(maps, [&](const height_map_t& m) {
    add(m.layer, false, measured_height_of(m));
  });
  runs::each_truth(run, [&](std::int32_t layer, const HeightMap& height) { add(layer, true, height); });
  if (rows.empty()) return;
  std::ranges::stable_sort(rows, {}, &Row::layer);
  const std::size_t table = sink.open(outline_table(prefix));
  for (const Row& row : rows) write(row, table, sink);
}

}  // namespace firn::report
