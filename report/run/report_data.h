// RunData holds the data of one recorded run for a report and metrics.csv.
#pragma once

#include <any>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/labs.h"
#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "firn/layer_metrics_t.hpp"
#include "report/run/report_ice_data.h"
#include "report/run/report_inks.h"
#include "report/run/run_health.h"
#include "runs/folder/documents.h"
#include "runs/folder/notes.h"
#include "runs/folder/run_meta.h"

namespace firn::report {

/// Adds to LAYER_METRICS of the last attempt at a layer what else its row has, with the truth from SIM_TRUTH
/// if a simulated world reported it. Heights and errors that no map led to are kNotMeasured.
struct LayerRow : layer_metrics_t {
  LayerRow() : layer_metrics_t{} {}
  explicit LayerRow(const layer_metrics_t& m);

  double look_s = 0;                             ///< of the camera's pictures and the ways to them
  double end_s = 0;                              ///< node time
  std::optional<ErrorStats> truth;               ///< of the true surface about the target
  std::optional<OutlineStats> true_outline;      ///< of the true surface; along paths of the last row's
  std::optional<OutlineStats> measured_outline;  ///< of the layer's map; of droplets
  int passes = 0;                                ///< of the stage that fired droplets, over all attempts
  int stage_runs = 0;   ///< straight ways of these passes: one for each row of cells, or sub-row
  int slower_runs = 0;  ///< of them: their droplets are nearer than the jet follows at full speed
};

/// Tells runs of one part from runs of others, which share no axis.
struct PartIdentity {
  std::string name;  ///< of the experiment
  std::string key;   ///< equal for equal parts: digest of the target, or the size of a part of paths
  double x_mm = 0, y_mm = 0, z_mm = 0;
};

/// A straight way over the surface, along which its heights are shown.
struct SurfaceCut {
  double x_mm = 0.0, y_mm = 0.0;        ///< its zero
  double along_x = 1.0, along_y = 0.0;  ///< unit vector
  double from_mm = 0.0, to_mm = 0.0;
};

struct ReportLab;

/// The unit in which a lab's heights are read.
struct HeightUnit {
  std::string name = "µm";
  double per_mm = 1e3;
};
HeightUnit height_unit(const LabWords& lab);

struct RunData {
  std::string folder;  ///< name of the run folder
  std::string scheme;
  PartIdentity part;
  LabWords words;
  runs::RunMeta meta;
  runs::RunNotes notes;
  std::optional<runs::RunResult> result;  ///< none = the run has not ended
  RunHealth health;
  std::vector<LayerRow> layers;    ///< by layer
  HeightMap height;                ///< last measured map; size 0: no map
  std::optional<HeightMap> truth;  ///< last true surface
  HeightMap target;
  Mask mask;
  const ReportLab* lab = nullptr;  ///< reader of this run
  std::optional<SurfaceCut> cut;   ///< of the cross-sections; none: along x through the middle row
  std::optional<IceData>
      ice;  ///< of a print along paths; height, target and mask are its last interval's then
  std::optional<InkData> inks;                                  ///< of a print with two inks
  std::any own;                                                 ///< of a lab beyond these
  std::vector<std::pair<std::string, std::string>> provenance;  ///< name, value; in reading order
};

/// Reads the data of a run.
/// @throws std::invalid_argument for a folder that is no run or lacks its target; record::FileError
RunData read_run_data(const std::filesystem::path& run, const ReportLab& lab);

}  // namespace firn::report
