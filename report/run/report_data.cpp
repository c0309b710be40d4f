#include "report/run/report_data.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <stdexcept>

#include "config/nozzles.h"
#include "core/grid/npy.h"
#include "core/path/job_codec.h"
#include "drivers/stage/raster.h"
#include "files/digest.h"
#include "files/record/checksum.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "firn/answer_t.hpp"
#include "firn/camera_command_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/enums.h"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/convert.h"
#include "lcmtypes/told_heights.h"
#include "report/run/report_ice.h"
#include "report/run/report_lab.h"
#include "report/run/report_lines.h"
#include "runs/folder/config_change.h"
#include "runs/folder/documents.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/run_messages.h"
#include "runs/read/truth.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;

// All that this file, health_of() and the labs' readers read.
runs::RunMessages::Channels read_channels() {
  runs::RunMessages::Channels names{std::string(channels::answer(NodeId::kCamera).name)};
  for (const std::string_view name :
       {channels::kHeightMap.name, channels::kLayerMetrics.name, channels::kStageCommand.name,
        channels::kCameraCommand.name, channels::kRunEnd.name, channels::kDepositionReport.name,
        channels::kPathReport.name, channels::kLayerPlan.name, channels::kLinePlan.name,
        channels::kFollowedPath.name, channels::kPathJob.name, channels::kPulseList.name,
        channels::kTrajectory.name, channels::kControlSurface.name})
    names.emplace(name);
  for (const ChannelInfo& channel : channel_table())
    if (channel.name.starts_with("FAULT_")) names.emplace(channel.name);
  return names;
}

std::string read_text(const fs::path& path) { return fs::is_regular_file(path) ? read_file(path) : ""; }

// A picture's time begins with the stage's move to its place and ends with the camera's answer.
void read_looks(const runs::RunMessages& messages, std::map<std::int32_t, LayerRow>& rows) {
  struct Look {
    std::int32_t layer = 0;
    std::int64_t begin_us = 0;
  };
  std::vector<std::int64_t> moves_us;
  messages.each<stage_command_t>(channels::kStageCommand.name, [&](const stage_command_t& m) {
    if (StageVerb(m.verb) == StageVerb::kMove) moves_us.push_back(m.header.utime_us);
  });
  std::map<std::int64_t, Look> looks;
  messages.each<camera_command_t>(channels::kCameraCommand.name, [&](const camera_command_t& m) {
    const auto after = std::ranges::upper_bound(moves_us, m.header.utime_us);
    looks[m.command_id] = {m.layer, after == moves_us.begin() ? m.header.utime_us : *std::prev(after)};
  });
  messages.each<answer_t>(channels::answer(NodeId::kCamera).name, [&](const answer_t& m) {
    const auto look = looks.find(m.command_id);
    if (look == looks.end()) return;
    if (const auto row = rows.find(look->second.layer); row != rows.end())
      row->second.look_s += double(m.header.utime_us - look->second.begin_us) * 1e-6;
    looks.erase(look);
  });
}

std::map<std::string, fs::path> inputs_of(const fs::path& run, const runs::ProvenanceDocument& provenance) {
  std::map<std::string, fs::path> files;
  for (const auto& [role, sha] : provenance.inputs) files.emplace(role, RunPaths(run).input_path(sha));
  return files;
}

// A run whose result is missing or damaged has not ended.
void read_result(const fs::path& file, RunData& data) try {
  data.result = runs::parse_result(read_text(file), file.string());
} catch (const std::invalid_argument&) {
}

void read_truth(const fs::path& run, bool outlined, RunData& data, std::map<std::int32_t, LayerRow>& rows) {
  runs::each_truth(run, [&](std::int32_t layer, HeightMap height) {
    if (height.spec != data.target.spec) return;
    if (const auto row = rows.find(layer); row != rows.end()) {
      row->second.truth = error_stats(height, data.target, data.mask);
      if (outlined) row->second.true_outline = outline_stats(height, data.target, data.mask);
    }
    data.truth = std::move(height);
  });
}

void read_provenance(const fs::path& run, const runs::ProvenanceDocument& p, RunData& data) {
  const auto text = [&](const char* key) { return p.text(key); };
  std::string command;
  for (const std::string& word : p.command_line) command += (command.empty() ? "" : " ") + word;
  const std::string config = read_text(RunPaths(run).experiment_path());
  char digest[20];
  std::snprintf(digest, sizeof digest, "%016llx",
                static_cast<unsigned long long>(record::checksum64(std::as_bytes(std::span(config)))));
  data.provenance = {{"run id", text("run_id")},
                     {"started", text("started_utc")},
                     {"host", text("host")},
                     {"commit", text("commit")},
                     {"platform", text("platform")},
                     {"kernel", text("kernel")},
                     {"plant model", text("plant_model")},
                     {"seeds", text("seeds")},
                     {"configuration digest (XXH64)", digest},
                     {"command line", command}};
}

// Beyond the paths a map of scattered readings is interpolation: no material was laid there, and the report
// shows no value.
HeightMap within(const HeightMap& height, const Mask& footprint) {
  HeightMap shown(height.spec, kNotMeasured);
  for (std::size_t c = 0; c < shown.size(); ++c)
    if (footprint.cells[c]) shown.cells[c] = height.cells[c];
  return shown;
}

void show_last_interval(RunData& data, std::map<std::int32_t, LayerRow>& rows) {
  for (const IceInterval& i : data.ice->intervals) {
    data.height = within(i.height, i.footprint);
    data.target = HeightMap(i.height.spec, i.nominal_mm);
    data.mask = i.footprint;
    data.truth = i.truth;
    if (const auto row = rows.find(i.layer); row != rows.end() && i.truth)
      row->second.truth = error_stats(*i.truth, data.target, data.mask);
  }
  if (!rows.empty()) rows.rbegin()->second.true_outline = data.ice->outline;
}

void measure_part(const HeightMap& target, const Mask& mask, PartIdentity& part) {
  const auto size_mm = part_size_mm(target, mask);
  part.x_mm = size_mm[0];
  part.y_mm = size_mm[1];
  part.z_mm = size_mm[2];
}

// The same part is sliced and measured in many ways: its size tells it, not its paths.
void identify_paths(const replay::NominalPart& whole, PartIdentity& part) {
  measure_part(whole.target, whole.mask, part);
  part.key = std::to_string(part.x_mm) + " " + std::to_string(part.y_mm) + " " + std::to_string(part.z_mm);
}

void read_paths(const RunRecord& run, RunData& data, std::map<std::int32_t, LayerRow>& rows) {
  data.ice = read_ice_data(run.folder, run.messages, run.input("paths"));
  identify_paths(data.ice->nominal, data.part);
  show_last_interval(data, rows);
}

std::string path_sections(const std::vector<NamedRun>& runs) {
  std::vector<NamedIce> ice;
  for (const NamedRun& r : runs)
    if (r.data->ice) ice.push_back({r.name, &*r.data->ice, r.style});
  return ice_sections(ice);
}

// Straight ways of the stage, of which the plan's passes consist.
void read_stage_runs(const RunRecord& run, std::map<std::int32_t, LayerRow>& rows) {
  std::optional<Experiment> experiment;  // needed where droplets are beside the centres
  run.messages.each<stage_command_t>(channels::kStageCommand.name, [&](const stage_command_t& m) {
    const auto row = rows.find(m.layer);
    if (StageVerb(m.verb) != StageVerb::kPass || row == rows.end()) return;
    if (m.n_offset > 0 && !experiment)
      experiment = parse_recorded_experiment(runs::recorded_config(run.folder), run.folder.string());
    const Placement placement =
        experiment ? placement_of(m, OffsetTable(experiment->actuation)) : Placement{};
    try {
      check(placement, from_message(m.grid));
    } catch (const std::invalid_argument&) {
      return;  // the audit names it
    }
    if (m.fires.size() != from_message(m.grid).size()) return;
    const drivers::RasterParams raster{.speed_mm_s = m.speed_mm_s,
                                       .max_rate_hz = experiment ? jets_rate_hz(*experiment) : 0.0};
    for (const drivers::RasterRun& r : drivers::plan_raster(fires_of(m), 0, raster, placement)) {
      ++row->second.stage_runs;
      row->second.slower_runs += r.speed_mm_s < m.speed_mm_s;
    }
  });
}

// A part on a grid of cells. `outlined`: it has an outline; a line fades beside its middle and has none.
void read_grid_part(const RunRecord& run, bool outlined, RunData& data,
                    std::map<std::int32_t, LayerRow>& rows) {
  const std::vector<std::byte> target = run.input("target"), mask = run.input("mask");
  GridSpec grid = data.height.spec;
  if (grid.size() == 0) {
    const NpyShape shape = npy_shape(target, "target");
    grid = {shape.nx, shape.ny, 1.0, 1.0, 0.0, 0.0};
  }
  data.target = height_map_from_npy(target, grid, "target");
  data.mask = mask_from_npy(mask, grid, "mask");
  data.part.key = sha256_hex(target) + sha256_hex(mask);
  if (run.has("geometry")) data.part.key += sha256_hex(run.input("geometry"));
  measure_part(data.target, data.mask, data.part);
  if (run.has("geometry")) data.inks = read_ink_data(run.messages, run.input("geometry"), data.mask);
  read_truth(run.folder, outlined, data, rows);
  run.messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    const auto row = rows.find(m.layer);
    if (const HeightMap height = measured_height_of(m);
        outlined && row != rows.end() && height.spec == data.target.spec)
      row->second.measured_outline = outline_stats(height, data.target, data.mask);
  });
  run.messages.each<deposition_report_t>(channels::kDepositionReport.name, [&](const deposition_report_t& m) {
    if (const auto row = rows.find(m.layer); row != rows.end()) ++row->second.passes;
  });
  read_stage_runs(run, rows);
}

void read_droplets(const RunRecord& run, RunData& data, std::map<std::int32_t, LayerRow>& rows) {
  read_grid_part(run, true, data, rows);
}

void read_lines_of(const RunRecord& run, RunData& data, std::map<std::int32_t, LayerRow>& rows) {
  read_grid_part(run, false, data, rows);
  data.own = read_line_data(run.messages);
  if (run.has("job")) data.cut = line_cut(decode_job(run.input("job")));
}

std::string sections_of_lines(const std::vector<NamedRun>& runs) {
  std::vector<NamedLines> lines;
  for (const NamedRun& r : runs)
    if (const auto* data = std::any_cast<LineData>(&r.data->own)) lines.push_back({r.name, data, r.style});
  return line_sections(lines);
}

}  // namespace

std::vector<std::byte> RunRecord::input(const std::string& role) const {
  const auto file = inputs.find(role);
  if (file == inputs.end())
    throw std::invalid_argument(RunPaths(folder).provenance_path().string() + ": names no input '" + role +
                                "'");
  if (!fs::is_regular_file(file->second))
    throw std::invalid_argument(file->second.string() + ": the input '" + role + "' is missing");
  const std::string text = read_text(file->second);
  const auto bytes = std::as_bytes(std::span(text));
  if (sha256_hex(bytes) != file->second.filename())
    throw std::invalid_argument(file->second.string() +
                                ": content does not have the SHA-256 of its name (input '" + role +
                                "' was changed)");
  return {bytes.begin(), bytes.end()};
}

LayerRow::LayerRow(const layer_metrics_t& m) : layer_metrics_t(m), end_s(double(m.header.utime_us) * 1e-6) {
  if (!heights_told(m))
    mean_height_mm = mean_error_mm = rms_mm = std_mm = min_error_mm = max_error_mm = volume_mm3 =
        kNotMeasured;
}

HeightUnit height_unit(const LabWords& lab) { return lab.in_mm ? HeightUnit{"mm", 1.0} : HeightUnit{}; }

RunData read_run_data(const fs::path& run, const ReportLab& lab) {
  const runs::RunMessages messages(run, read_channels());
  const fs::path file = RunPaths(run).provenance_path();
  const runs::ProvenanceDocument provenance = runs::parse_provenance(read_text(file), file.string());
  RunData data;
  data.folder = fs::weakly_canonical(run).filename().string();
  data.scheme = provenance.text("scheme");
  data.part.name = provenance.text("name");
  data.meta = runs::run_meta(provenance);
  data.notes = runs::read_notes(run);
  read_result(RunPaths(run).result_path(), data);

  messages.each<height_map_t>(channels::kHeightMap.name,
                              [&](const height_map_t& m) { data.height = measured_height_of(m); });
  std::map<std::int32_t, LayerRow> rows;
  messages.each<layer_metrics_t>(channels::kLayerMetrics.name, [&](const layer_metrics_t& m) {
    rows.insert_or_assign(m.layer, LayerRow(m));
  });
  read_looks(messages, rows);
  read_provenance(run, provenance, data);
  data.health = health_of(messages);
  data.lab = &lab;
  lab.read({run, messages, inputs_of(run, provenance)}, data, rows);
  for (auto& [layer, row] : rows) data.layers.push_back(std::move(row));
  // A record of others may be of any scale, whatever its lab.
  const auto above_1_mm = [](double h) { return std::abs(h) >= 1.0; };
  if (!provenance.text("imported").empty() && std::ranges::any_of(data.target.cells, above_1_mm))
    data.words.in_mm = true;
  return data;
}

const ReportLab kDropletReport{&read_droplets, nullptr};
const ReportLab kPathReport{&read_paths, &path_sections};
const ReportLab kLineReport{&read_lines_of, &sections_of_lines};

}  // namespace firn::report
