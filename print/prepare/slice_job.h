// Computes planned layers from meshes, one after another, for firn slice and firn reproduce.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/slice.h"
#include "core/grid/parallel.h"
#include "core/slice/coverage/coverage.h"
#include "core/slice/mesh/slicer.h"
#include "core/slice/paths/layer_paths.h"
#include "core/slice/paths/path_codec.h"
#include "core/slice/paths/path_plan.h"
#include "files/mesh/mesh_file.h"

namespace firn {

/// Holds the time of a stage: wall time, and processor time of this process on all its threads.
struct StageTime {
  std::string stage;  ///< with the thesis's name: "FACETREAD", …
  double wall_s = 0.0, cpu_s = 0.0;
};

/// Adds the time of its own lifetime to its stage.
class StageTimer {
 public:
  StageTimer(std::vector<StageTime>& times, const std::string& stage);
  ~StageTimer();

 private:
  StageTime& time_;
  double wall_s_, cpu_s_;
};

struct PartReport {
  std::string file, format;
  std::uint8_t material = 0;
  std::vector<std::string> file_defects;
  slice::MeshFacts facts;
  slice::SliceCounts counts;
  std::vector<slice::Defect> defects;
};

/// Holds all layers as regions, bottom up.
struct SlicedJob {
  std::vector<slice::LayerRegions> layers;
  std::vector<PartReport> parts;
  std::vector<StageTime> times;
};

/// Receives the progress of a job: the fraction done, and the current activity in words.
using SliceProgress = std::function<void(double fraction, const std::string& doing)>;

/// Returns which number of facets of a mesh file holds.
FacetCount facet_count(const SliceSettings& settings);

/// Returns the options of the contours, with PATHFILTER's share of the job's chord tolerance.
slice::SliceOptions contour_options(const SliceSettings& settings);

/// Reads, places, slices and supports. @throws UsageError: a file, or settings that the meshes do not fit
SlicedJob slice_meshes(const std::vector<std::filesystem::path>& files, const SliceSettings& settings,
                       const ParallelFor& parallel, const SliceProgress& progress);

/// Returns the tools of `materials` materials, by material.
std::vector<std::string> material_tools(const SliceSettings& settings, std::size_t materials);
/// Returns the head of the job's path file.
slice::PathFileHead path_file_head(const SlicedJob& job, const SliceSettings& settings);

struct PlannedLayer {
  slice::LayerRegions regions;
  slice::LayerPaths paths;
  std::vector<slice::MaterialUse> use;
  double transit_mm = 0.0;
  std::vector<slice::Coverage> coverage;  ///< if the settings ask for it
  std::vector<std::byte> encoded;         ///< for the path file, if asked for
  std::string gcode;                      ///< if asked for
};

/// Holds the outputs to compute for each layer, in any thread.
struct LayerBytes {
  bool encoded = false;                                        ///< PlannedLayer::encoded
  std::function<std::string(const slice::LayerPaths&)> gcode;  ///< PlannedLayer::gcode; may be empty
};

/// Plans every layer and passes the layers to `sink` in order, one at a time, in any thread; at most some
/// dozens are in memory. Consumes the job's regions.
void plan_layers(SlicedJob& job, const SliceSettings& settings, const ParallelFor& parallel,
                 const SliceProgress& progress, const LayerBytes& bytes,
                 const std::function<void(PlannedLayer&&)>& sink);

}  // namespace firn
