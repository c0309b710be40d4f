#include "files/path/path_file.h"

#include <fstream>

#include "files/lowercase.h"
#include "files/usage_error.h"

namespace firn {
void read_paths(const std::filesystem::path& file, const PathSink& sink) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw UsageError(file.string() + ": is a folder, not a file");
  if (!std::filesystem::is_regular_file(file, error)) throw UsageError(file.string() + ": no such file");
  const std::string extension = lowercase(file.extension().string());
  if (extension == kLayerFileEndings[0]) return read_paths_layers(file, sink);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw UsageError(file.string() + ": cannot be read");
  const double size = double(std::filesystem::file_size(file, error));
  if (extension == ".csv") return read_paths_csv(in, file.string(), size, sink);
  if (extension == ".json") return read_paths_json(in, file.string(), size, sink);
  if (extension == ".svg") return read_paths_svg(in, file.string(), size, sink);
  if (extension == ".dxf") return read_paths_dxf(in, file.string(), size, sink);
  for (const std::string_view gcode : kGcodeEndings)
    if (extension == gcode) return read_paths_gcode(in, file.string(), size, sink);
  throw UsageError(
      file.string() +
      ": must end in .gcode, .nc, .ngc, .g, .gco, .cnc, .tap, .dxf, .svg, .csv, .json or .paths");
}

}  // namespace firn
