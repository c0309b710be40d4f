// Processor time (user and system) of the slicer's stages from a mesh file to regions, on one thread.
//   build/bench/slice_stages MESH [CHORD_TOLERANCE_MM [REPEATS]]
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <utility>
#include <vector>

#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "files/mesh/mesh_file.h"

namespace {

using namespace firn;

double cpu_s() {
  rusage r{};
  getrusage(RUSAGE_SELF, &r);
  return double(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
         1e-6 * double(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
}

constexpr std::array<const char*, 7> kStages = {
    "read", "place", "intersect", "link", "read to linked", "filter and repair", "all"};

struct Outcome {
  std::array<double, kStages.size()> seconds{};
  slice::Sliced sliced;
};

Outcome once(const char* file, const slice::SliceOptions& options) {
  Outcome out;
  const double begin = cpu_s();
  double before = begin;
  const auto lap = [&](std::size_t stage) { out.seconds[stage] = cpu_s() - std::exchange(before, cpu_s()); };
  const MeshFile mesh(file);
  const slice::FacetView facets = mesh.facets();
  lap(0);
  slice::Placement placement;
  placement.unit_mm = mesh.data().mm_per_unit;
  for (slice::AxisPlace& t : placement.translation) t.mode = slice::AxisPlace::Mode::kNumber;
  const slice::Affine affine = slice::place(facets, placement, serially);
  lap(1);
  slice::Segments segments =
      slice::intersect(facets, affine, slice::layer_planes(options.layer_height_mm, affine.high.z), serially);
  const slice::MeshFacts facts = segments.facts;
  lap(2);
  std::vector<slice::Contours> contours = slice::link(std::move(segments), options, serially);
  lap(3);
  out.seconds[4] = cpu_s() - begin;
  out.sliced = slice::regions(std::move(contours), facts, options, serially);
  lap(5);
  out.seconds[6] = cpu_s() - begin;
  return out;
}

int run(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: slice_stages MESH [CHORD_TOLERANCE_MM [REPEATS]]\n");
    return 2;
  }
  slice::SliceOptions options;
  if (argc > 2) options.chord_tolerance_mm = std::atof(argv[2]);
  const int repeats = argc > 3 ? std::max(1, std::atoi(argv[3])) : 5;
  std::array<std::vector<double>, kStages.size()> seconds;
  Outcome last;
  for (int n = 0; n < repeats; ++n) {
    last = once(argv[1], options);
    for (std::size_t k = 0; k < kStages.size(); ++k) seconds[k].push_back(last.seconds[k]);
  }
  const slice::Sliced& s = last.sliced;
  double volume_mm3 = 0.0;
  std::size_t meeting = 0;
  for (const geometry::Region& layer : s.layers) {
    volume_mm3 += geometry::area_mm2(layer) * options.layer_height_mm;
    meeting += geometry::first_contact(layer).has_value();
  }
  std::printf("%s: %zu facets, chord tolerance %g mm, %d runs\n", argv[1], s.facts.facets,
              options.chord_tolerance_mm, repeats);
  for (std::size_t k = 0; k < kStages.size(); ++k) {
    std::sort(seconds[k].begin(), seconds[k].end());
    std::printf("  %-18s median %.4f s, least %.4f s\n", kStages[k], seconds[k][seconds[k].size() / 2],
                seconds[k][0]);
  }
  std::printf(
      "  %zu layers, %zu segments, %zu contours, %zu points linked, %zu kept; %zu layers merged, %zu with "
      "rings that meet\n",
      s.layers.size(), s.counts.segments, s.counts.contours, s.counts.linked_points, s.counts.kept_points,
      s.counts.repaired_layers, meeting);
  std::printf("  volume %.3f mm3 of contours, %.3f by the divergence theorem (%+.4f %%)%s\n", volume_mm3,
              s.facts.volume_mm3, 100.0 * (volume_mm3 / s.facts.volume_mm3 - 1.0),
              s.facts.closed ? "" : ", surface not closed");
  rusage r{};
  getrusage(RUSAGE_SELF, &r);
  std::printf("  peak memory %.0f MiB\n", double(r.ru_maxrss) / 1024.0);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "slice_stages: %s\n", error.what());
  return 1;
}
