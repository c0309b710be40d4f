// Measures the cost of the rings of a concentric fill, four ways, on all layers of a mesh:
//   build/bench/slice_rings MESH [CHORD_TOLERANCE_MM]
// Firn's front from the original outline; Clipper's offset of the original outline for each ring; Clipper's
// offset of the ring before (errors pile up); and, without any ring, the segment Voronoi diagram of
// Boost.Polygon, from which they could be read off.
#include <boost/polygon/voronoi.hpp>

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "core/geometry/clipper.h"
#include "core/geometry/simplify_ring.h"
#include "core/slice/mesh/slicer.h"
#include "core/slice/offset/offset_rings.h"
#include "files/mesh/mesh_file.h"
#include "tests/bench/bench.h"

namespace firn::bench::slice_rings {

namespace {

using namespace firn;
using namespace firn::slice;

double cpu_s() { return double(std::clock()) / CLOCKS_PER_SEC; }

struct Tally {
  std::size_t rings = 0, points = 0;
  void add(const geometry::Rings& r) {
    rings += r.size();
    points += r.points.size();
  }
};

template <class F>
void time(const char* name, F&& f) {
  const double start = cpu_s();
  const Tally tally = f();
  std::printf("%-34s %7.3f s CPU %8zu rings %9zu points\n", name, cpu_s() - start, tally.rings, tally.points);
}

std::size_t voronoi_vertices(const geometry::Region& region) {
  boost::polygon::voronoi_builder<std::int32_t> builder;
  for (std::size_t r = 0; r < region.size(); ++r) {
    const auto ring = region[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const geometry::Point a = ring[i], b = ring[i + 1 < ring.size() ? i + 1 : 0];
      builder.insert_segment(a.x, a.y, b.x, b.y);
    }
  }
  boost::polygon::voronoi_diagram<double> diagram;
  builder.construct(&diagram);
  return diagram.num_vertices();
}

geometry::Rings simplified(const geometry::Rings& rings, double tolerance_mm) {
  geometry::Rings thin;
  std::vector<geometry::Vec> line;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    line.clear();
    for (const geometry::Point p : rings[r]) line.push_back(to_vec(p));
    simplify_ring(line, tolerance_mm * geometry::kUnitsPerMm, thin);
  }
  return thin;
}

}  // namespace

FIRN_BENCH(slice_rings) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s MESH [CHORD_TOLERANCE_MM]\n", argv[0]);
    return 2;
  }
  SliceOptions options;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc > 2) options.chord_tolerance_mm = std::atof(argv[2]);
  const double tolerance_mm = options.chord_tolerance_mm;
  const MeshFile mesh(argv[1]);
  const Sliced sliced = slice::slice(mesh.facets(), {}, options, serially);
  std::size_t points = 0;
  for (const geometry::Region& layer : sliced.layers) points += layer.points.size();
  std::printf("%s: %zu layers, %zu points, chord tolerance %g mm\n", argv[1], sliced.layers.size(), points,
              tolerance_mm);
  const RingPlan plan;
  time("front from the original", [&] {
    Tally tally;
    for (const geometry::Region& layer : sliced.layers)
      for (const geometry::Rings& rings : offset_rings(layer, plan, tolerance_mm).levels) tally.add(rings);
    return tally;
  });
  time("Boost.Polygon Voronoi, no rings", [&] {
    Tally tally;
    for (const geometry::Region& layer : sliced.layers) tally.points += voronoi_vertices(layer);
    return tally;
  });
  time("Clipper, each from the ring before", [&] {
    Tally tally;
    for (geometry::Region ring : sliced.layers) {
      for (int level = 0; !ring.empty(); ++level) {
        ring = simplified(
            clipper_offset(ring, plan.distance_mm(level) - (level ? plan.distance_mm(level - 1) : 0),
                           tolerance_mm),
            tolerance_mm);
        tally.add(ring);
      }
    }
    return tally;
  });
  time("Clipper, each from the original", [&] {
    Tally tally;
    for (const geometry::Region& layer : sliced.layers) {
      for (int level = 0;; ++level) {
        const geometry::Rings rings = clipper_offset(layer, plan.distance_mm(level), tolerance_mm);
        if (rings.empty()) break;
        tally.add(rings);
      }
    }
    return tally;
  });
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s: %s\n", argv[0], e.what());
  return 1;
}

}  // namespace firn::bench::slice_rings
