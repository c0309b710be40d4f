// Any bytes as a path file: the first byte chooses CSV, JSON, G-code, SVG or DXF.
#include <cmath>
#include <sstream>

#include "files/path/path_file.h"
#include "files/usage_error.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  std::istringstream in(std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  const auto check = [&](InputPath&& p) {
    require(!p.path.points.empty(), "a path has points");
    for (const Point2& q : p.path.points)
      require(std::abs(q.x_mm) <= kMaxCoordinate_mm && std::abs(q.y_mm) <= kMaxCoordinate_mm,
              "coordinates keep their limit");
    const auto& speeds = p.speed_limit.point_mm_s;
    require(speeds.empty() || speeds.size() == p.path.points.size(), "a speed for each point or for none");
    for (double v : speeds) require(v > 0.0, "speeds are above 0");
    require(p.yaw_point_rad.empty() || p.yaw_point_rad.size() == p.path.points.size(),
            "a yaw for each point or for none");
    require(p.speed_limit.path_mm_s > 0.0, "the path's speed is above 0");
  };
  try {
    constexpr decltype(&read_paths_csv) kReaders[] = {read_paths_csv, read_paths_json, read_paths_gcode,
                                                      read_paths_svg, read_paths_dxf};
    kReaders[data[0] % std::size(kReaders)](in, "fuzz", double(size), check);
  } catch (const UsageError& e) {
    require(std::string(e.what()).find("fuzz:") == 0, "an error names the file");
  }
  return 0;
}
