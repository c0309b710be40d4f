#include "print/import/imported_run.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "core/grid/cell_quality.h"
#include "core/grid/device.h"
#include "core/grid/npy.h"
#include "core/options/for_people.h"
#include "core/statistics/median.h"
#include "files/exit_codes.h"
#include "files/increments.h"
#include "files/json.h"
#include "files/record/event_log.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/deposition_report_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/run_end_t.hpp"
#include "lcmtypes/convert.h"
#include "lcmtypes/schema.h"
#include "print/inputs/targets.h"
#include "runs/folder/documents.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runtime/build_info.h"
#include "runtime/wal_file.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxDrops = 127;

// The messages of one node, one step a message, as a print would have recorded them.
class ImportedNode {
 public:
  ImportedNode(const runs::RunFolder& folder, NodeId id, const Blobs& blobs, record::EventLogWriter& log)
      : file_(folder.wal_path(info(id).name), false, std::size_t(1) << 20),
        outbox_(id, folder.run_id()),
        log_(log) {
    WalHead head;
    head.node = info(id).name;
    head.run_id = folder.run_id();
    head.commit = build_commit();
    head.platform = platform_description();
    head.config_toml = folder.experiment_toml();
    head.type_texts = lcm_type_texts();
    for (const Blob& b : blobs) head.blobs.emplace_back(b.role, b.sha256);
    std::vector<std::byte> bytes;
    encode_head(head, bytes);
    file_.append(WalKind::kHead, bytes);
    log_.append(0, channels::config(id).name, config_message(head));
  }

  template <class Message>
  void send(const Channel<Message>& channel, const Message& message, std::int64_t now_us) {
    Event event;
    event.kind = EventKind::kWake;
    event.now = {now_us};
    std::vector<std::byte> bytes;
    encode_event(step_, event, bytes);
    file_.append(WalKind::kEvent, bytes);
    outbox_.begin({now_us}, 0);
    outbox_.send(channel, message);
    bytes.clear();
    encode_outputs(step_, 0, outbox_, bytes);
    file_.append(WalKind::kOutputs, bytes);
    log_.append(now_us, channel.name, outbox_.at(0).bytes);
    ++step_;
  }
  void close() { file_.flush(); }

 private:
  WalFile file_;
  Outbox outbox_;
  record::EventLogWriter& log_;
  std::uint64_t step_ = 0;
};

struct Part {
  HeightMap target;  ///< of the last layer
  Mask mask;
};

// The part is where anything was commanded, or else where the last layer was seen.
Part part_of(const LayerRecord& r, const ImportSource& source, std::vector<std::string>& assumptions) {
  Part p{HeightMap(r.grid, 0.0), Mask(r.grid)};
  for (const Grid<double>& input : r.inputs)
    for (std::size_t c = 0; c < input.size(); ++c)
      if (input.cells[c] > 0) p.mask.cells[c] = 1;
  const bool commanded = p.mask.count() > 0;
  const auto seen = [](const HeightMap& map) {
    return std::ranges::any_of(map.cells, [](double h) { return !std::isnan(h); });
  };
  const auto last = std::find_if(r.heights.rbegin(), r.heights.rend(), seen);
  double sum = 0;
  std::int64_t n = 0;
  for (std::size_t c = 0; c < last->size(); ++c) {
    if (std::isnan(last->cells[c])) continue;
    if (!commanded) p.mask.cells[c] = 1;
    if (!p.mask.cells[c]) continue;
    sum += last->cells[c];
    ++n;
  }
  if (!commanded) assumptions.push_back("no input is told: the part is where the last map has heights");
  if (!r.targets.empty() && !source.target_mm) {
    const auto told = std::find_if(r.targets.rbegin(), r.targets.rend(), seen);
    if (told != r.targets.rend()) {
      HeightMap whole = *told;
      fill_along_x(whole);
      for (std::size_t c = 0; c < p.target.size(); ++c)
        if (p.mask.cells[c]) p.target.cells[c] = whole.cells[c];
      return p;
    }
  }
  const double target_mm = source.target_mm.value_or(n > 0 ? sum / double(n) : 0.0);
  if (!source.target_mm)
    assumptions.push_back(std::string(kNoTarget) + ": flat, at the mean of the last map, " +
                          for_people(target_mm) + " mm (--target-mm, a column of target or error)");
  for (std::size_t c = 0; c < p.target.size(); ++c)
    if (p.mask.cells[c]) p.target.cells[c] = target_mm;
  return p;
}

// The heights of a layer whose errors count: measured, and with a target if the record tells any.
HeightMap judged_heights(const LayerRecord& r, std::size_t layer) {
  HeightMap judged = r.heights[layer];
  for (std::size_t c = 0; c < judged.size(); ++c) {
    const bool bridged = !r.bridged.empty() && r.bridged[layer].cells[c];
    const bool untold = !r.targets.empty() && std::isnan(r.targets[layer].cells[c]);
    if (bridged || untold) judged.cells[c] = kNotMeasured;
  }
  return judged;
}

Blob input_blob(const LayerRecord& r) {
  std::vector<std::byte> all;
  for (const Grid<double>& input : r.inputs) {
    HeightMap layer(r.grid);
    layer.cells = input.cells;
    std::ranges::copy(to_npy(layer), std::back_inserter(all));
  }
  return make_blob(r.input_is_speed ? kRecordedSpeeds : kRecordedInputs, std::move(all));
}

// Droplets of a layer. What is not told counts as none.
DropletPattern drops_of(const LayerRecord& r, std::size_t layer, const ImportSource& source, double& rounded,
                        std::int64_t& untold) {
  DropletPattern drops(r.grid);
  if (int(layer) <= r.base) return drops;
  const Grid<double>& input = r.inputs[layer - 1];
  for (std::size_t c = 0; c < input.size(); ++c) {
    if (std::isnan(input.cells[c])) {
      ++untold;
      continue;
    }
    const double wanted = input.cells[c] / (source.input_per_drop > 0 ? source.input_per_drop : 1.0);
    const double whole = std::round(wanted);
    const auto wrong = [&](const std::string& what) {
      return UsageError(source.name + ": layer " + std::to_string(layer) + ", cell (" +
                        std::to_string(c % std::size_t(r.grid.nx)) + ", " +
                        std::to_string(c / std::size_t(r.grid.nx)) + "): an input of " +
                        std::to_string(input.cells[c]) + " " + what);
    };
    if (!(whole >= 0 && whole <= kMaxDrops))
      throw wrong("is " + std::to_string(whole) + " droplets, not 0 to 127; --input-per-drop scales it");
    if (source.input_per_drop <= 0 && whole != wanted)
      throw wrong(
          "is no whole number of droplets; --input-per-drop scales it and rounds, --column speed=NAME takes "
          "it as the speed of a bead");
    rounded = std::max(rounded, std::abs(whole - wanted));
    drops.cells[c] = std::uint8_t(whole);
  }
  return drops;
}

height_map_t map_message(const LayerRecord& r, int layer) {
  const HeightMap& map = r.heights[std::size_t(layer)];
  const Mask bridged = r.bridged.empty() ? Mask(r.grid) : r.bridged[std::size_t(layer)];
  height_map_t m{};
  m.n = std::int32_t(map.size());
  m.layer = layer;
  m.map_id = layer + 1;
  m.grid = to_message(map.spec);
  std::int64_t seen = 0;
  for (std::size_t c = 0; c < map.size(); ++c) {
    const bool measured = !std::isnan(map.cells[c]) && !bridged.cells[c];
    m.height_mm.push_back(float(map.cells[c]));
    m.quality.push_back(std::int8_t(measured ? CellQuality::kMeasured : CellQuality::kGuessed));
    seen += measured;
  }
  m.noise_std_mm = noise_of_bends_mm(map);
  m.measured_fraction = double(seen) / double(map.size());
  return m;
}

layer_metrics_t metrics_message(const LayerRecord& r, const Part& part, int layer, std::int64_t drops,
                                std::int64_t total) {
  const HeightMap map = judged_heights(r, std::size_t(layer));
  const HeightMap& wanted = r.targets.empty() ? part.target : r.targets[std::size_t(layer)];
  const ErrorStats e = error_stats(map, wanted, part.mask);
  layer_metrics_t m{};
  m.layer = layer;
  m.map_id = layer + 1;
  double sum = 0, target = 0;
  std::int64_t n = 0;
  for (std::size_t c = 0; c < map.size(); ++c) {
    if (!part.mask.cells[c] || std::isnan(map.cells[c])) continue;
    sum += map.cells[c];
    target += wanted.cells[c];
    ++n;
  }
  m.target_mean_mm = n > 0 ? target / double(n) : 0;
  m.mean_height_mm = n > 0 ? sum / double(n) : 0;
  m.mean_error_mm = e.mean_mm;
  m.rms_mm = e.rms_mm;
  m.std_mm = e.std_mm;
  m.min_error_mm = e.min_mm;
  m.max_error_mm = e.max_mm;
  m.volume_mm3 = sum * map.spec.pitch_x_mm * map.spec.pitch_y_mm;
  m.drops = drops;
  m.drops_total = total;
  m.cells_guessed = e.missing;
  return m;
}

void mark_imported(const runs::RunFolder& folder, const ImportSource& source,
                   const std::vector<std::string>& assumptions) {
  const fs::path file = folder.provenance_path();
  auto j = nlohmann::ordered_json::parse(read_file(file));
  j["scheme"] = "imported";
  j["plant_model"] = "none";
  std::string assumed;
  for (const std::string& line : assumptions) assumed += (assumed.empty() ? "" : "; ") + line;
  j["imported"] = {{"from", source.name}, {"sha256", source.sha256}, {"assumptions", assumed}};
  write_file_atomically(file, j.dump(2) + "\n");
}

}  // namespace

double noise_of_bends_mm(const HeightMap& map) {
  std::vector<double> bends;
  for (int j = 0; j < map.spec.ny; ++j)
    for (int i = 1; i + 1 < map.spec.nx; ++i) {
      const double bend = map.at(i - 1, j) - 2 * map.at(i, j) + map.at(i + 1, j);
      if (!std::isnan(bend)) bends.push_back(std::abs(bend));
    }
  if (bends.size() < 8) return 0.0;
  return std::min(statistics::kMadToStd * statistics::upper_median(bends) / std::sqrt(6.0), 100.0);
}

ImportedRun write_imported_run(LayerRecord r, const Experiment& experiment, const ImportSource& source,
                               const fs::path& root) {
  if (r.points == 0) throw UsageError(source.name + ": holds no height");
  ImportedRun run;
  run.assumptions = r.assumptions;
  const Part part = part_of(r, source, run.assumptions);
  std::vector<DropletPattern> drops;  // before the folder is made: an input may be refused
  double rounded = 0;
  std::int64_t untold = 0;
  for (std::size_t layer = 1; layer <= r.inputs.size() && !r.input_is_speed; ++layer)
    drops.push_back(drops_of(r, layer, source, rounded, untold));
  if (rounded > 0)
    run.assumptions.push_back("inputs are rounded to whole droplets, by " + std::to_string(rounded) +
                              " at most");
  if (untold > 0) run.assumptions.push_back(std::to_string(untold) + " inputs are not told: taken as none");
  run.assumptions.push_back("the noise of a map is not told: estimated from its second differences along x");
  run.assumptions.push_back("times are those of a layer a second");
  Blobs blobs{make_blob("target", to_npy(part.target)), make_blob("mask", to_npy(part.mask))};
  if (!r.inputs.empty()) blobs.push_back(input_blob(r));
  const runs::RunFolder folder = runs::RunFolder::create(root, experiment, blobs, runs::own_command_line());
  const runs::RunLock lock(folder.path(), runs::RunUse::kWrite);
  run.folder = folder.path();
  mark_imported(folder, source, run.assumptions);
  runs::SealedIncarnation seal(folder.path(), folder.run_id(), false, false);
  record::EventLogWriter log(folder.log_path());
  ImportedNode mapper(folder, NodeId::kSurfaceMapper, blobs, log),
      controller(folder, NodeId::kController, blobs, log), scheduler(folder, NodeId::kScheduler, blobs, log);
  for (std::size_t layer = 0; layer < r.heights.size(); ++layer) {
    const std::int64_t now_us = std::int64_t(layer + 1) * 1'000'000;
    std::int64_t fired = 0;
    if (layer > 0 && layer <= drops.size()) {
      const DropletPattern& pattern = drops[layer - 1];
      fired = pattern.total();
      layer_plan_t plan{};
      plan.n = std::int32_t(pattern.size());
      plan.layer = std::int32_t(layer);
      plan.map_id = std::int64_t(layer);
      plan.passes = pattern.passes();
      plan.grid = to_message(r.grid);
      plan.reason = "imported";
      plan.drops.assign(pattern.cells.begin(), pattern.cells.end());
      controller.send(channels::kLayerPlan, plan, now_us - 3);
      for (int pass = 0; pass < std::max(1, pattern.passes()); ++pass) {
        deposition_report_t d{};
        d.n = std::int32_t(pattern.size());
        d.layer = std::int32_t(layer);
        d.pass_index = pass;
        d.passes = std::max(1, pattern.passes());
        d.map_id = std::int64_t(layer);
        d.material = 1;
        d.round = pass;
        d.sub_patterns = 1;
        d.cured = 1;
        d.outcome = std::int8_t(Outcome::kDone);
        d.triggered_stage = d.triggered_jet = d.confirmed = -1;  // nobody counted
        d.grid = to_message(r.grid);
        for (const std::uint8_t n : pattern.cells) d.drops.push_back(std::int8_t(n > pass));
        d.commanded = std::count(d.drops.begin(), d.drops.end(), 1);
        d.unknown_from = d.unknown_to = d.commanded;  // nothing is in doubt
        scheduler.send(channels::kDepositionReport, d, now_us - 2);
      }
    }
    run.droplets += fired;
    mapper.send(channels::kHeightMap, map_message(r, int(layer)), now_us - 1);
    if (layer > 0)
      scheduler.send(channels::kLayerMetrics, metrics_message(r, part, int(layer), fired, run.droplets),
                     now_us);
  }
  run.layers = int(r.heights.size()) - 1;
  run_end_t end{};
  end.layers = run.layers;
  end.reason = "imported";
  scheduler.send(channels::kRunEnd, end, std::int64_t(r.heights.size()) * 1'000'000 + 1);
  for (ImportedNode* node : {&mapper, &controller, &scheduler}) node->close();
  log.close();
  runs::RunResult result{"finished", kOk, run.layers, "imported from " + source.name + ", not replayable"};
  folder.write_result(result);
  seal.ended(result);
  return run;
}

std::optional<RecordedInputs> recorded_inputs(const Blobs& inputs, const GridSpec& grid) {
  const auto at = std::ranges::find_if(
      inputs, [](const Blob& b) { return b.role == kRecordedSpeeds || b.role == kRecordedInputs; });
  if (at == inputs.end()) return std::nullopt;
  RecordedInputs out{at->role == kRecordedSpeeds, {}};
  const std::size_t size = to_npy(HeightMap(grid)).size();
  const std::span<const std::byte> all(at->bytes);
  for (std::size_t from = 0; from < all.size(); from += size)
    out.layers.push_back(
        height_map_from_npy(all.subspan(from, std::min(size, all.size() - from)), grid,
                            at->role + " of layer " + std::to_string(out.layers.size() + 1)));
  return out;
}

bool is_imported(const fs::path& run) {
  const fs::path file = RunPaths(run).provenance_path();
  if (!fs::is_regular_file(file)) return false;
  try {
    return !runs::parse_provenance(read_file(file), file.string()).text("imported").empty();
  } catch (const std::invalid_argument&) {
    return false;  // whoever reads the run names it
  }
}

bool records_speeds(const fs::path& run) {
  const Blobs inputs = runs::RunFolder::open(run).inputs();
  return std::ranges::find(inputs, kRecordedSpeeds, &Blob::role) != inputs.end();
}

void refuse_beads(const fs::path& run, const std::string& command) {
  if (records_speeds(run))
    throw UsageError(
        run.string() + ": was imported with speeds of beads: " + command +
        " knows laboratories of droplets and of ice paths, and none of beads; firn identify computes the "
        "law of its beads, ln dh = a ln v + b");
}

void refuse_imported(const fs::path& run, const std::string& command) {
  if (is_imported(run))
    throw UsageError(run.string() + " is imported, not replayable: " + command +
                     " needs the events of a print");
}

}  // namespace firn
