// The slicer's path file as paths to plan.
#include <fmt/core.h>

#include "files/path/layer_file.h"
#include "files/path/path_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

InputPath input_path(const slice::LayerPaths& layer, std::size_t n, const slice::PathFileHead& head) {
  InputPath out;
  out.path = slice::to_path(layer, n);
  const std::string& tool =
      out.path.kind == PathKind::kMeasurement ? head.laser : head.materials[out.path.material].tool;
  if (!tool.empty()) out.tool = tool;
  return out;
}

}  // namespace

void read_paths_layers(const std::filesystem::path& file, const PathSink& sink) {
  const std::string name = file.string();
  std::int64_t number = 0;
  try {
    LayerReader in(file);
    while (const auto layer = in.next())
      for (std::size_t n = 0; n < layer->lines.size(); ++n) {
        InputPath path = input_path(*layer, n, in.head());
        path.number = ++number;
        path.place = fmt::format("{}: layer {}, path {}", name, layer->layer, n + 1);
        path.fraction = in.fraction();
        if (path.path.points.size() > kMaxPathPoints)
          throw UsageError(path.place + fmt::format(": more than {} points in one path", kMaxPathPoints));
        sink(std::move(path));
      }
  } catch (const FormatError& e) {
    throw UsageError(name + ": " + e.what());
  } catch (const record::FileError& e) {
    throw UsageError(e.what());
  }
  if (number == 0) throw UsageError(name + ": holds no paths");
}

}  // namespace firn
