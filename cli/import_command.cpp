#include "cli/import_command.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "config/include.h"
#include "files/digest.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/layer_record.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/import/imported_run.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

MatrixLabels labels_named(const std::string& word) {
  constexpr std::pair<std::string_view, MatrixLabels> kWords[] = {{"detect", MatrixLabels::kDetect},
                                                                  {"none", MatrixLabels::kNone},
                                                                  {"row", MatrixLabels::kRow},
                                                                  {"column", MatrixLabels::kColumn},
                                                                  {"both", MatrixLabels::kBoth}};
  const auto found = std::ranges::find(kWords, word, &std::pair<std::string_view, MatrixLabels>::first);
  if (found == std::end(kWords))
    throw UsageError("--labels " + word + ": must be one of detect, none, row, column, both");
  return found->second;
}

LayerRecordOptions record_options(const ImportOptions& o) {
  LayerRecordOptions r;
  for (const std::string& text : o.columns) {
    const std::size_t at = text.find('=');
    if (at == text.npos || at == 0) throw UsageError("--column " + text + ": ROLE=NAME is wanted");
    r.columns[text.substr(0, at)] = text.substr(at + 1);
  }
  r.pitch_x_mm = o.pitch_mm.value_or(0.0);
  r.pitch_y_mm = o.pitch_y_mm.value_or(r.pitch_x_mm);
  r.unit = o.unit;
  r.labels = labels_named(o.labels);
  r.layer_number = o.layer_number;
  r.increments = o.increments;
  return r;
}

// One sum over the names and digests of all files.
std::string digest_of(const std::vector<std::string>& places) {
  std::string all;
  for (const std::string& place : places) {
    if (place.empty()) continue;
    std::vector<fs::path> files{place};
    if (fs::is_directory(place)) {
      files.clear();
      for (const auto& entry : fs::directory_iterator(place))
        if (entry.is_regular_file()) files.push_back(entry.path());
      std::ranges::sort(files);
    }
    for (const fs::path& file : files) {
      const std::string text = read_file(file);
      all += file.filename().string() + " " + sha256_hex(std::as_bytes(std::span(text))) + "\n";
    }
  }
  return sha256_hex(std::as_bytes(std::span(all)));
}

std::string setting(const char* key, double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  std::string number(text, end);
  if (number.find_first_of(".e") == number.npos) number += ".0";
  return std::string(key) + "=" + number;
}

Experiment imported_experiment(const ImportOptions& o, const LayerRecord& record) {
  const GridSpec& g = record.grid;
  std::vector<std::string> settings{
      "run.name=\"" + o.name + "\"",
      "grid.nx=" + std::to_string(g.nx),
      "grid.ny=" + std::to_string(g.ny),
      setting("grid.pitch_x_mm", g.pitch_x_mm),
      setting("grid.pitch_y_mm", g.pitch_y_mm),
      setting("grid.origin_x_mm", g.origin_x_mm),
      setting("grid.origin_y_mm", g.origin_y_mm),
  };
  // Nothing of this is printed: the record's mask and target are the run's. The values pass every check.
  constexpr double kWithin = 1 - 1e-6, kSlow_hz = 100, kRows_hz = 10;
  settings.insert(settings.end(),
                  {"part.shape=\"cuboid\"", setting("part.width_mm", kWithin * g.nx * g.pitch_x_mm),
                   setting("part.depth_mm", kWithin * g.ny * g.pitch_y_mm),
                   setting("process.pass_speed_mm_s", kSlow_hz * g.pitch_x_mm),
                   setting("process.scan_speed_mm_s", kRows_hz * g.pitch_y_mm)});
  settings.insert(settings.end(), o.overrides.begin(), o.overrides.end());
  if (!o.experiment.empty()) return load_experiment(o.experiment, settings);
  return parse_experiment({{"firn import", ""}}, settings);
}

}  // namespace

int run_import(const ImportOptions& o) {
  for (const auto& value : {o.pitch_mm, o.pitch_y_mm, o.input_per_drop})
    if (value && !(*value > 0)) throw UsageError("--pitch-mm, --pitch-y-mm and --input-per-drop are above 0");
  const LayerRecordOptions how = record_options(o);
  const bool folder = fs::is_directory(o.record);
  for (const auto& [option, value] : {std::pair{"--input", &o.input},
                                      {"--speed", &o.speed},
                                      {"--target", &o.target},
                                      {"--error", &o.error}})
    if (!folder && !value->empty())
      throw UsageError(std::string(option) + " is of a record that is a folder; a table has a column of it");
  if (!folder && o.increments)
    throw UsageError(
        "--increments is of a record that is a folder; in a table --column increment=NAME says it");
  LayerRecord record = folder ? read_layer_files({o.record, o.input, o.speed, o.target, o.error}, how)
                              : read_layer_table(read_file(o.record), o.record, how);
  ImportSource source{o.record, digest_of({o.record, o.input, o.speed, o.target, o.error}),
                      o.input_per_drop.value_or(0.0), o.target_mm};
  const Experiment experiment = imported_experiment(o, record);
  if (o.target_mm) record.targets.clear();
  const std::int64_t points = record.points, missing = record.missing, bridged = record.bridges;
  const ImportedRun run = write_imported_run(std::move(record), experiment, source, o.runs);
  if (o.json) {
    const nlohmann::ordered_json said = {{"run", run.folder.string()},
                                         {"layers", run.layers},
                                         {"droplets", run.droplets},
                                         {"heights", points},
                                         {"bridged", bridged},
                                         {"missing", missing},
                                         {"assumptions", run.assumptions}};
    std::puts(said.dump().c_str());
    return kOk;
  }
  std::printf(
      "%s: %d layers of %d x %d cells, %lld heights, %lld bridged, %lld missing, %lld droplets; imported, "
      "not "
      "replayable\n",
      run.folder.c_str(), run.layers, experiment.grid.nx, experiment.grid.ny, static_cast<long long>(points),
      static_cast<long long>(bridged), static_cast<long long>(missing), static_cast<long long>(run.droplets));
  for (const std::string& line : run.assumptions) std::printf("  %s\n", line.c_str());
  return kOk;
}

void declare_import(OptionSet& options) {
  auto& o = options.calls(run_import);
  options
      .option("RECORD", o.record, "CSV table with a row a point, or folder with a .npy or .csv file a layer")
      .required();
  options.option("--input", o.input, "folder of the commanded inputs, a file a layer");
  options.option("--speed", o.speed, "folder of the commanded speeds of beads [mm/s], a file a layer");
  options.option("--target", o.target,
                 "folder of the heights wanted after each layer; a single number is of all cells");
  options.option("--error", o.error, "folder of the errors after each layer: height - target");
  options.flag("--increments", o.increments, "the folder's files hold increments, not heights");
  options
      .option("--column", o.columns,
              "ROLE=NAME: layer, x, y, segment, height, increment, input, speed, target, error")
      .one_value_each();
  options.option("--unit", o.unit, "of lengths that name none: mm, um, nm, cm, m, in, mil");
  options
      .option("--labels", o.labels,
              "first row and column of a matrix file that are names, no heights: none, row, column, both or "
              "detect")
      .show_default();
  options.option(
      "--layer-number", o.layer_number,
      "number of a file's name that is the layer: 1 = the first, -1 = the last; default: detected");
  options.option("--pitch-mm", o.pitch_mm, "size of a cell; default: from the positions");
  options.option("--pitch-y-mm", o.pitch_y_mm, "the same along y");
  options.option("--target-mm", o.target_mm,
                 "height of the part; default: the record's target, or the mean of the last map");
  options.option("--input-per-drop", o.input_per_drop,
                 "input of one droplet; inputs are rounded to whole ones");
  options.option("--experiment", o.experiment, "experiment whose model and settings the run gets");
  options.override_option(o.overrides, "KEY=VALUE, after the experiment");
  options.option("--name", o.name, "of the run").show_default();
  options.runs_option(o.runs, "where run folders go");
  options.json_flag(o.json);
}

}  // namespace firn
