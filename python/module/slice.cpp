#include <array>
#include <map>

#include "config/slice.h"
#include "core/options/enumerators.h"
#include "print/prepare/slice_job.h"
#include "python/module/interruptible.h"
#include "python/module/module.h"

namespace firn::python {
namespace {

constexpr std::array kKinds{"boundary", "fill", "hook", "measurement"};
static_assert(kKinds.size() == kTableSize<PathKind>);

std::map<int, slice::LayerPaths> sliced(const std::vector<std::string>& meshes,
                                        const std::vector<int>& layers, const SliceSettings& settings,
                                        int threads, const std::atomic<bool>& stop) {
  const SliceProgress progress = [&](double, const std::string&) {
    if (stop) throw Stopped();
  };
  const ParallelFor parallel = parallel_in_c_locale(threads);
  SlicedJob job = slice_meshes({meshes.begin(), meshes.end()}, settings, parallel, progress);
  std::map<int, slice::LayerPaths> wanted;
  for (const int k : layers) {
    if (k < 1 || std::size_t(k) > job.layers.size())
      throw std::invalid_argument("layers: " + std::to_string(k) + " is not one of the job's 1 to " +
                                  std::to_string(job.layers.size()));
    wanted[k];
  }
  plan_layers(job, settings, parallel, progress, {}, [&](PlannedLayer&& planned) {
    const auto at = wanted.find(planned.paths.layer);
    if (at != wanted.end()) at->second = std::move(planned.paths);
  });
  return wanted;
}

py::list paths_of(const slice::LayerPaths& layer, const std::vector<std::string>& tools) {
  using namespace py::literals;
  py::list paths;
  for (std::size_t n = 0; n < layer.lines.size(); ++n) {
    const slice::PathInfo& info = layer.info[n];
    const auto line = layer.lines[n];
    py::array_t<double> points({py::ssize_t(line.size()), py::ssize_t(2)});
    auto at = points.mutable_unchecked<2>();
    for (std::size_t k = 0; k < line.size(); ++k) {
      at(py::ssize_t(k), 0) = line[k].x * geometry::kMmPerUnit;
      at(py::ssize_t(k), 1) = line[k].y * geometry::kMmPerUnit;
    }
    py::dict path("layer"_a = layer.layer, "material"_a = int(info.material),
                  "kind"_a = kKinds[std::size_t(info.kind)], "closed"_a = info.closed,
                  "width_mm"_a = info.width * geometry::kMmPerUnit,
                  "layer_height_mm"_a = layer.height * geometry::kMmPerUnit,
                  "z_mm"_a = layer.z * geometry::kMmPerUnit, "points_mm"_a = points);
    if (info.material < tools.size() && !tools[info.material].empty()) path["tool"] = tools[info.material];
    paths.append(path);
  }
  return paths;
}

}  // namespace

py::dict slice(const std::vector<std::string>& meshes, const std::vector<int>& layers,
               const std::string& settings_file, const std::vector<std::string>& settings, int threads) {
  const SliceSettings s = load_slice_settings(settings_file, settings);
  const auto wanted =
      interruptible([&](const std::atomic<bool>& stop) { return sliced(meshes, layers, s, threads, stop); });
  const std::vector<std::string> tools = material_tools(s, 256);
  py::dict found;
  for (const int k : layers) found[py::int_(k)] = paths_of(wanted.at(k), tools);
  return found;
}

}  // namespace firn::python
