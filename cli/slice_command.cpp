#include "cli/slice_command.h"

#include <fmt/core.h>
#include <malloc.h>

#include <algorithm>
#include <cstdio>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/output_files.h"
#include "config/include.h"
#include "config/labs.h"
#include "core/options/number.h"
#include "files/exit_codes.h"
#include "files/path/layer_file.h"
#include "files/path/path_file.h"
#include "files/usage_error.h"
#include "lcmtypes/schema.h"
#include "print/inputs/ice_inputs.h"
#include "print/interrupt.h"
#include "print/prepare/gcode.h"
#include "print/prepare/plan_outputs.h"
#include "print/prepare/slice_job.h"
#include "print/prepare/slice_report.h"
#include "print/progress.h"
#include "report/paths/slice_pictures.h"
#include "runtime/thread_pool.h"

namespace firn {
namespace {

struct SliceInterrupted {};

// Layers ask for the same few MiB again and again: handing them back to the system each time costs a detailed
// part some hundredths of its time in page faults.
void keep_freed_memory() {
  ::mallopt(M_TRIM_THRESHOLD, 256 << 20);
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TOP_PAD, 8 << 20);
}

// "--support overhang 30 a.stl" leaves the angle among the meshes.
std::optional<double> take_angle(std::vector<std::string>& meshes) {
  for (auto m = meshes.begin(); m != meshes.end(); ++m) {
    const auto angle = whole_number<double>(*m);
    if (!angle || std::filesystem::exists(*m)) continue;
    meshes.erase(m);
    return angle;
  }
  return std::nullopt;
}

SliceSettings settings_of(SliceCommandOptions& o) {
  std::vector<std::string> overrides = o.overrides;
  if (!o.support.empty()) {
    overrides.push_back("support.kind=" + o.support);
    if (o.support == "overhang")
      if (const auto angle = take_angle(o.meshes))
        overrides.push_back(fmt::format("support.overhang_deg={}", *angle));
  }
  if (o.tolerance_mm) overrides.push_back(fmt::format("contour.tolerance_mm={}", *o.tolerance_mm));
  return load_slice_settings(o.config, overrides);
}

void check_outputs(const SliceCommandOptions& o) {
  std::vector<std::filesystem::path> inputs(o.meshes.begin(), o.meshes.end());
  if (!o.config.empty()) inputs.push_back(o.config);
  check_output_files(std::move(inputs), {o.output, o.gcode, o.svg, o.png, o.layer_json});
  check_ending("-o", o.output, kLayerFileEndings);
  check_ending("--gcode", o.gcode, kGcodeEndings);
}

/// The layers of an experiment's part as a print of it would be given them.
int slice_experiment(const SliceCommandOptions& o) {
  if (o.output.empty()) throw UsageError("--experiment needs -o: it writes a path file and nothing else");
  if (!o.meshes.empty() || !o.config.empty() || !o.overrides.empty() || !o.support.empty() ||
      o.tolerance_mm || !o.gcode.empty() || !o.layers.empty() || !o.svg.empty() || !o.png.empty() ||
      !o.layer_json.empty())
    throw UsageError(
        "--experiment names mesh and settings itself: it goes with -o, --threads and --json only");
  check_ending("-o", o.output, kLayerFileEndings);
  const std::filesystem::path file = o.experiment;
  const Experiment e = load_experiment(file);
  if (!prints_paths(e)) throw UsageError(o.experiment + ": its lab prints no paths");
  const slice::PrintPaths paths = slice_ice_part(e, file.parent_path());
  LayerWriter out(o.output, paths.head);
  for (const slice::LayerPaths& layer : paths.layers)
    out.add(slice::encode(layer), layer, slice::material_use(layer));
  out.finish();
  const slice::PathFileTotals& t = out.totals();
  if (o.json)
    fmt::print("{{\"file\": {}, \"layers\": {}, \"paths\": {}, \"points\": {}}}\n", json_string(o.output),
               t.layers, t.paths, t.points);
  else
    fmt::print("{}: {} layers, {} paths, {} points\n", o.output, t.layers, t.paths, t.points);
  return kOk;
}

void check_options(const SliceCommandOptions& o) {
  if (o.meshes.empty()) throw UsageError("MESH is missing");
  check_outputs(o);
  const bool pictures = !o.svg.empty() || !o.png.empty() || !o.layer_json.empty();
  if (pictures && o.layers.empty()) throw UsageError("--svg, --png and --layer-json need --layer K");
  if (!pictures && !o.layers.empty()) throw UsageError("--layer needs --svg, --png or --layer-json");
  if (!o.layer_json.empty() && o.layers.size() != 1) throw UsageError("--layer-json takes one --layer");
  if (o.layers.size() > 100) throw UsageError("--layer: at most 100");
  for (int k : o.layers)
    if (k < 1) throw UsageError(fmt::format("--layer {}: layers count from 1", k));
  if (o.png_width < 100 || o.png_width > 10'000)
    throw UsageError(fmt::format("--png-width {}: must lie in [100, 10000]", o.png_width));
}

void write_text(const std::string& file, const std::string& text, std::vector<SliceOutput>& outputs) {
  TextOutput out(file);
  out.write(text);
  out.finish();
  outputs.push_back({file, text.size()});
}

class SliceRun {
 public:
  SliceRun(const SliceCommandOptions& options, const SliceSettings& settings)
      : o_(options),
        s_(settings),
        threads_(thread_count(options.threads)),
        parallel_(parallel_on(threads_)) {}

  void run() {
    const SliceProgress progress = [this](double fraction, const std::string& doing) {
      if (InterruptGuard::raised()) throw SliceInterrupted();
      progress_.show(fraction, doing);
    };
    job_ = slice_meshes({o_.meshes.begin(), o_.meshes.end()}, s_, parallel_, progress);
    for (int k : o_.layers)
      if (std::size_t(k) > job_.layers.size())
        throw UsageError(fmt::format("--layer {}: the job has {} layers", k, job_.layers.size()));
    const slice::PathFileHead head = path_file_head(job_, s_);
    if (!o_.output.empty()) paths_.emplace(o_.output, head);
    LayerBytes bytes;
    bytes.encoded = paths_.has_value();
    if (!o_.gcode.empty()) {
      gcode_.emplace(o_.gcode);
      write_gcode(gcode_start(s_.gcode, head.made_by));
      bytes.gcode = [this](const slice::LayerPaths& l) { return gcode_layer(l, s_.gcode); };
    }
    pictured_.resize(o_.layers.size());
    plan_layers(job_, s_, parallel_, progress, bytes, [this](PlannedLayer&& l) { take(std::move(l)); });
    finish();
  }

 private:
  void write_gcode(const std::string& text) {
    gcode_->write(text);
    gcode_bytes_ += text.size();
  }

  void take(PlannedLayer&& l) {
    sums_.add(l);
    if (paths_) paths_->add(l.encoded, l.paths, l.use);
    if (gcode_) write_gcode(l.gcode);
    for (std::size_t n = 0; n < o_.layers.size(); ++n)
      if (o_.layers[n] == l.paths.layer) pictured_[n] = {l.regions, l.paths};
  }

  void finish() {
    if (paths_) {
      paths_->finish();
      outputs_.push_back({o_.output, paths_->bytes()});
    }
    if (gcode_) {
      write_gcode(gcode_end(s_.gcode));
      gcode_->finish();
      outputs_.push_back({o_.gcode, gcode_bytes_});
    }
    if (!o_.svg.empty()) write_text(o_.svg, report::layers_svg(pictured_), outputs_);
    if (!o_.png.empty()) write_text(o_.png, report::layers_png(pictured_, o_.png_width), outputs_);
    if (!o_.layer_json.empty())
      write_text(o_.layer_json, report::layer_json(pictured_[0].paths, material_tools(s_, 256)), outputs_);
    if (o_.json) {
      std::fputs(slice_json(job_, s_, sums_, outputs_, threads_).c_str(), stdout);
      return;
    }
    std::fputs(slice_text(job_, s_, sums_).c_str(), stdout);
    for (const SliceOutput& f : outputs_)
      std::fprintf(stderr, "wrote %s (%.2f MB)\n", f.file.c_str(), double(f.bytes) / 1e6);
  }

  const SliceCommandOptions& o_;
  const SliceSettings& s_;
  int threads_;
  ParallelFor parallel_;
  JobProgress progress_{"slice"};
  SlicedJob job_;
  SliceSums sums_;
  std::optional<LayerWriter> paths_;
  std::optional<TextOutput> gcode_;
  std::uint64_t gcode_bytes_ = 0;
  std::vector<report::PicturedLayer> pictured_;
  std::vector<SliceOutput> outputs_;
};

}  // namespace

int run_slice(const SliceCommandOptions& given) {
  SliceCommandOptions o = given;
  if (!o.experiment.empty()) return slice_experiment(o);
  const SliceSettings settings = settings_of(o);
  check_options(o);
  keep_freed_memory();
  InterruptGuard guard;
  try {
    SliceRun(o, settings).run();
    return kOk;
  } catch (const SliceInterrupted&) {
    std::fputs("firn slice: interrupted; nothing was written\n", stderr);
    return kInterrupted;
  } catch (const record::FileError& e) {
    if (e.disk_full()) throw;
    throw UsageError(e.what());
  }
}

void declare_slice(OptionSet& options) {
  auto& o = options.calls(run_slice);
  options.option("MESH", o.meshes, "*.stl, *.ply, *.obj or *.3mf; each is a part");
  options.option("--experiment", o.experiment, "instead: the part of an experiment, as its print slices it");
  options.option("-o,--output", o.output, "path file, for firn plan and firn print: docs/formats.md");
  options.option("-c,--config", o.config, "settings: docs/slice-settings.md");
  options.override_option(o.overrides);
  options.option("--support", o.support, "full, none, or overhang ANGLE [deg from the vertical]");
  options.option("--tolerance", o.tolerance_mm,
                 "no path leaves its exact place by more [mm]; 0 keeps every point");
  options.option("--gcode", o.gcode, "for other printers and viewers");
  options.option("--layer", o.layers, "to be pictured; several make a contact sheet: 10,50,100")
      .separated_by(',')
      .one_value_each();
  options.option("--svg", o.svg, "picture of --layer");
  options.option("--png", o.png, "the same");
  options.option("--png-width", o.png_width, "pixels").show_default();
  options.option("--layer-json", o.layer_json, "the paths of --layer, as firn plan reads them");
  options.thread_option(o.threads, "; the bytes do not depend on it");
  options.json_flag(o.json);
}

}  // namespace firn
