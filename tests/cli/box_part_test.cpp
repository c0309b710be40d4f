// The part of Fig. 4-15 and the caliper that measures it.
#include "cli/box_part.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "cli/reproduce.h"
#include "cli/reproduce_parts.h"

using namespace firn;
using namespace firn::barnett;

namespace {

// Within the outline moved outward, whose corners are rounds.
bool within(const BoxPart& b, double x, double y, double outward) {
  const double half = 0.5 * b.side_mm + outward;
  if (std::abs(x) > half || std::abs(y) > half) return false;
  const std::size_t corner = y < 0.0 ? (x < 0.0 ? 0 : 1) : x > 0.0 ? 2 : 3;
  const double r = std::max(0.0, b.round_mm[corner] + outward), dx = std::abs(x) - (half - r), dy = std::abs(y) - (half - r);
  return dx <= 0.0 || dy <= 0.0 || std::hypot(dx, dy) <= r;
}

HeightMap ice_of(const BoxPart& b, double grown_mm) {
  HeightMap h({500, 500, 0.25, 0.25, -62.4, -62.4}, 0.0);
  for (int j = 0; j < 500; ++j)
    for (int i = 0; i < 500; ++i) {
      const double x = h.spec.x_mm(i), y = h.spec.y_mm(j);
      const bool plate = within(b, x, y, b.ledge_mm + grown_mm), wall = within(b, x, y, grown_mm) && !within(b, x, y, -b.wall_mm - grown_mm);
      h.at(i, j) = wall ? b.height_mm : plate ? b.plate_mm : 0.0;
    }
  return h;
}

}  // namespace

TEST_CASE("The box on its plate is a closed surface with the nominal dimensions of Table 5-1") {
  const BoxPart part;
  CHECK(part.diagonal_mm() == Approx(123.5).margin(0.05));
  for (const bool turned : {false, true}) {
    const SampleMesh m = mesh_of(part, turned);
    std::map<std::pair<slice::Corner, slice::Corner>, int> edges;
    double volume = 0.0;
    for (const auto& t : m.triangles) {
      const slice::Corner &a = m.vertices[t[0]], &b = m.vertices[t[1]], &c = m.vertices[t[2]];
      ++edges[{a, b}], ++edges[{b, c}], ++edges[{c, a}];
      volume += (double(a[0]) * (double(b[1]) * c[2] - double(b[2]) * c[1]) - double(a[1]) * (double(b[0]) * c[2] - double(b[2]) * c[0]) +
                 double(a[2]) * (double(b[0]) * c[1] - double(b[1]) * c[0])) / 6.0;
    }
    int open = 0;
    for (const auto& [edge, n] : edges) {
      const auto back = edges.find({edge.second, edge.first});
      open += back == edges.end() || back->second != n;
    }
    CHECK(open == 0);
    CHECK(volume > 105e3);
    CHECK(volume < 120e3);
  }
}

TEST_CASE("The caliper reads a perfect part's dimensions, and outside dimensions larger by what the outline grew") {
  const BoxPart part;
  for (const double grown : {0.0, 0.15, 0.4})
    for (const Dimension& d : measured(part, ice_of(part, grown)))
      for (const double v : d.measured_mm) {
        INFO(d.name << " grown by " << grown << ": " << v << " of " << d.nominal_mm);
        const bool thickness = d.name == "l2" || d.name == "l6";
        // The corner rounded by as much as it grew stays sharp along the diagonal only by sqrt(2) of it.
        const double more = thickness ? 0.0 : 2.0 * grown;
        CHECK(std::abs(v - d.nominal_mm - more) < (d.name == "l3" ? 0.6 : 0.3));
        CHECK(d.measured_mm.size() == 4);
      }
}

TEST_CASE("A small part like that of Fig. 4-15 is printed and measured, and three ways of moving are timed") {
  ReproduceOptions options;
  options.paper = "barnett";
  options.quick = true;
  options.threads = 1;
  const auto results = reproduce(options, {{"barnett", "build-time", "4.4", 1, &reproduce_barnett_build_time}, {"barnett", "part", "5.3", 1, &reproduce_barnett_part}});
  REQUIRE(results.size() == 2);
  for (const auto& result : results)
    for (const ReproduceRow& row : result.rows) {
      INFO(row.id << ": " << text_of(row.ours, row.decimals, row.unit));
      CHECK(row.pass.value_or(true));
    }
  CHECK(results[0].rows.size() == 7);
  CHECK(results[1].rows.size() == 9);
  CHECK(results[1].pictures.size() == 1);
}
