// Duration and planning time of the motions of a whole job: `drive_times JOB.csv [X,Y]` plans every path of a
// CSV file (x_mm,y_mm; blank lines between paths) with the part's frame at X,Y of the Cobra 600 and prints
// seconds to drive, points per second of user CPU time, and refused paths. `certified_bench job` writes such
// files. Written so that it compiles with older commits, too: drive_times.sh compares two.
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/motion/planner.h"
#if __has_include("core/path/rounding.h")
#include "core/path/rounding.h"
#endif

namespace {

using namespace firn;
using namespace firn::motion;

#if !__has_include("core/path/rounding.h")
double rounding_mm(const std::vector<Point2>&) { return 0.0; }
#endif

double user_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

std::vector<std::vector<Point2>> read_job(std::FILE* file) {
  std::vector<std::vector<Point2>> paths(1);
  char line[256];
  while (std::fgets(line, sizeof line, file)) {
    Point2 p;
    if (std::sscanf(line, "%lf,%lf", &p.x_mm, &p.y_mm) == 2)
      paths.back().push_back(p);
    else if (!paths.back().empty())
      paths.emplace_back();
  }
  if (paths.back().empty()) paths.pop_back();
  return paths;
}

/// As `firn plan` without options; a template, since older options have no point_noise_mm.
template <class Options>
Options options_for(const std::vector<Point2>& points) {
  Options options;
  if constexpr (requires { options.point_noise_mm; }) options.point_noise_mm = rounding_mm(points);
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  std::FILE* const file = argc > 1 ? std::fopen(argv[1], "r") : nullptr;
  Point2 origin{380.0, 0.0};
  if (!file || (argc > 2 && std::sscanf(argv[2], "%lf,%lf", &origin.x_mm, &origin.y_mm) != 2)) {
    std::fprintf(stderr, "usage: drive_times JOB.csv [X,Y]\n");
    return 2;
  }
  const auto paths = read_job(file);
  std::fclose(file);
  const auto arm = make_scara(cobra600());
  PlanWorkspace work;
  std::size_t points = 0, refused = 0;
  double drive_s = 0.0;
  const double start = user_seconds();
  for (const auto& path : paths) {
    PathInput input;
    input.points = path;
    input.origin = origin;
    const PlanResult result = plan(input, *arm, cobra600_limits(), options_for<PlanOptions>(path), work);
    points += path.size();
    refused += result.ok() ? 0 : 1;
    if (result.ok()) drive_s += result.continuous_s;
  }
  const double user = user_seconds() - start;
  std::printf("%zu paths, %zu points, %zu refused: drive %.3f s, planned in %.3f s, %.0f points/s\n",
              paths.size(), points, refused, drive_s, user, double(points) / user);
  return 0;
}
