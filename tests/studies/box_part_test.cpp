// The part of Fig. 4-15 and the caliper that measures it.
#include "studies/reproduce/barnett/box_part.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/motion/planner.h"
#include "studies/reproduce/barnett/build_time.h"
#include "studies/reproduce/reproduce.h"
#include "studies/reproduce/reproduce_parts.h"

using namespace firn;
using namespace firn::barnett;

namespace {

// Within the outline moved outward, whose corners are rounds.
bool within(const BoxPart& b, double x, double y, double outward) {
  const double half = 0.5 * b.side_mm + outward;
  if (std::abs(x) > half || std::abs(y) > half) return false;
  const std::size_t corner = y < 0.0 ? (x < 0.0 ? 0 : 1) : x > 0.0 ? 2 : 3;
  const double r = std::max(0.0, b.round_mm[corner] + outward), dx = std::abs(x) - (half - r),
               dy = std::abs(y) - (half - r);
  return dx <= 0.0 || dy <= 0.0 || std::hypot(dx, dy) <= r;
}

HeightMap ice_of(const BoxPart& b, double grown_mm) {
  HeightMap h({500, 500, 0.25, 0.25, -62.4, -62.4}, 0.0);
  for (int j = 0; j < 500; ++j)
    for (int i = 0; i < 500; ++i) {
      const double x = h.spec.x_mm(i), y = h.spec.y_mm(j);
      const bool plate = within(b, x, y, b.ledge_mm + grown_mm),
                 wall = within(b, x, y, grown_mm) && !within(b, x, y, -b.wall_mm - grown_mm);
      h.at(i, j) = wall ? b.height_mm : plate ? b.plate_mm : 0.0;
    }
  return h;
}

WallBand band_of(const BoxPart& b, double grown_mm, double height_mm) {
  HeightMap h = ice_of(b, grown_mm);
  for (double& c : h.cells) c = c == b.height_mm ? height_mm : 0.0;
  return {height_mm, std::move(h)};
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
      ++edges[{a, b}];
      ++edges[{b, c}];
      ++edges[{c, a}];
      volume += (double(a[0]) * (double(b[1]) * c[2] - double(b[2]) * c[1]) -
                 double(a[1]) * (double(b[0]) * c[2] - double(b[2]) * c[0]) +
                 double(a[2]) * (double(b[0]) * c[1] - double(b[1]) * c[0])) /
                6.0;
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

TEST_CASE(
    "The caliper reads a perfect part's dimensions, and outside dimensions larger by what the outline grew") {
  const BoxPart part;
  for (const double grown : {0.0, 0.15, 0.4}) {
    const std::vector<WallBand> bands(4, band_of(part, grown, 4.75));
    for (const Dimension& d : measured(part, ice_of(part, grown), bands, {3.0, 0.0}))
      for (const double v : d.measured_mm) {
        INFO(d.name << " grown by " << grown << ": " << v << " of " << d.nominal_mm);
        const bool thickness = d.name == "l2" || d.name == "l6";
        const double more = thickness ? 0.0 : 2.0 * grown;
        CHECK(std::abs(v - d.nominal_mm - more) < 0.3);
        CHECK(d.measured_mm.size() == 4);
      }
  }
}

TEST_CASE("Jaws that come to rest over 1 mm crush a sharp corner by half a millimetre, and nothing flat") {
  const BoxPart part;
  const std::vector<WallBand> bands(4, band_of(part, 0.0, 4.75));
  const auto sharp = measured(part, ice_of(part, 0.0), bands, {3.0, 0.0}),
             crushed = measured(part, ice_of(part, 0.0), bands);
  for (std::size_t n = 0; n < sharp.size(); ++n)
    for (std::size_t k = 0; k < 4; ++k) {
      INFO(sharp[n].name);
      CHECK(sharp[n].measured_mm[k] - crushed[n].measured_mm[k] ==
            Approx(sharp[n].name == "l3" ? 0.5 : 0.0).margin(sharp[n].name == "l3" ? 0.15 : 0.02));
    }
}

TEST_CASE("The edge of a rough wall is where half of its layers reach, at whatever height it is measured") {
  const BoxPart part;
  for (const double share : {0.3, 0.7}) {  // of layers that reach 0.8 mm farther out
    std::vector<WallBand> bands;
    for (const double height_mm : {1.25, 3.75, 5.0, 5.0}) {
      WallBand band = band_of(part, 0.0, (1.0 - share) * height_mm);
      const WallBand farther = band_of(part, 0.8, share * height_mm);
      for (std::size_t c = 0; c < band.ice.cells.size(); ++c) band.ice.cells[c] += farther.ice.cells[c];
      band.height_mm = height_mm;
      bands.push_back(std::move(band));
    }
    const Dimension l3 = measured(part, ice_of(part, 0.0), bands, {3.0, 0.0})[2];
    REQUIRE(l3.measured_mm.size() == 4);
    for (const double v : l3.measured_mm)
      CHECK(v - l3.nominal_mm == Approx(share > 0.5 ? 1.6 : 0.0).margin(0.35));
    CHECK(*std::max_element(l3.measured_mm.begin(), l3.measured_mm.end()) -
              *std::min_element(l3.measured_mm.begin(), l3.measured_mm.end()) <
          0.01);
  }
}

TEST_CASE(
    "A way from rest to rest takes as long as the certified planner's motion along it, and its phases cover "
    "it") {
  const Machine machine = parse_machine(kBoxMachine, "the Cobra 600");
  const auto arm = make_arm(machine);
  motion::MotionLimits limits = motion_limits(machine);
  limits.joint = {};
  const motion::RateLimits& l = limits.position;
  for (const double d : {0.3, 3.0, 15.0, 15.7, 40.0, 46.8, 47.0, 200.0}) {
    INFO(d << " mm");
    const double whole = rest_to_rest_s(d, l);
    const std::vector<Point2> points{{0.0, 0.0}, {d, 0.0}};
    motion::PathInput in{.points = points};
    in.origin = {350.0, 0.0};
    const motion::PlanResult planned = motion::plan(in, *arm, limits);
    REQUIRE(planned.ok());
    CHECK(planned.continuous_s == Approx(whole).epsilon(0.03));
    // Jerk, acceleration and speed as they are driven: half of the way in half of the time, no limit passed.
    const double dt = whole / 40000.0, knee = l.acceleration / l.jerk;
    const double peak_s = std::min({0.25 * whole, knee}),
                 hold_s = std::min(0.5 * whole, l.rate / l.acceleration + knee) - 2.0 * peak_s;
    double a = 0.0, v = 0.0, s = 0.0;
    for (double t = 0.5 * dt; t < 0.5 * whole; t += dt) {
      const double jerk = t < peak_s                  ? l.jerk
                          : t < peak_s + hold_s       ? 0.0
                          : t < 2.0 * peak_s + hold_s ? -l.jerk
                                                      : 0.0;
      a += jerk * dt;
      v += a * dt;
      s += v * dt;
    }
    CHECK(v <= l.rate * 1.001);
    CHECK(s == Approx(0.5 * d).epsilon(0.002));
  }
  CHECK(rest_to_rest_s(0.0, l) == 0.0);
}

TEST_CASE(
    "The paths of a built part are each planned once and counted, and lines at their whole speed take ramps "
    "beside them") {
  BoxPart part;
  part.side_mm = 32.0;
  part.height_mm = 5.0;
  part.plate_mm = 2.5;
  part.round_mm = {0.0, 6.0, 5.0, 4.0};
  const motion::RateLimits l = motion_limits(parse_machine(kBoxMachine, "the Cobra 600")).position;
  const BoxFolder folder(part, false);
  const BuildPaths rings = build_paths(
      folder, l, {"layer.height_mm=0.25", "measure.on=0", "part.gap_mm=0", "scaffold.gap_mm=0"}, 1);
  CHECK(rings.layers == 20);
  CHECK(rings.count() > std::int64_t(rings.paths.size()));
  double sum = 0.0;
  CHECK(motion_s(rings, [&](const motion::PathInput& in) { return sum += double(in.points.size()), 1.0; }) ==
        Approx(double(rings.count())));
  CHECK(rings.run_up_s == 0.0);
  CHECK(rings.transit_s > 0.0);
  const BuildPaths lines = build_paths(
      folder, l, {"layer.height_mm=0.25", "measure.on=0", "part.fill=lines", "scaffold.fill=lines"}, 1);
  CHECK(lines.run_up_s > 0.1 * double(lines.count()));
  // Boundaries are 1.5 mm wide and fill 3.0 mm, layers 0.25 mm high.
  CHECK(rings.volume_mm3 < rings.length_mm() * 3.0 * 0.25);
  CHECK(rings.volume_mm3 > rings.length_mm() * 1.5 * 0.25);
}

TEST_CASE("A small part like that of Fig. 4-15 is printed and measured, and three ways of moving are timed") {
  ReproduceOptions options;
  options.paper = "barnett";
  options.quick = true;
  options.threads = 1;
  const auto results = reproduce(options, {{"barnett", "build-time", "4.4", 1, &reproduce_barnett_build_time},
                                           {"barnett", "part", "5.3", 1, &reproduce_barnett_part}});
  REQUIRE(results.size() == 2);
  for (const auto& result : results) {
    INFO(result.error);
    CHECK(result.error.empty());
    for (const ReproduceRow& row : result.rows) {
      INFO(row.id << ": " << text_of(row.ours, row.decimals, row.unit));
      CHECK_FALSE(row.fails());
    }
  }
  CHECK(results[0].rows.size() == 4);
  CHECK(results[0].beside.size() == 15);
  std::map<std::string, double> h;
  const auto take = [&](const std::string& id, const RowValue& value) {
    if (const double* v = std::get_if<double>(&value))
      h[id.substr(std::string("barnett.build-time.").size())] = *v;
  };
  for (const ReproduceRow& row : results[0].rows) take(row.id, row.ours);
  for (const BesideRow& row : results[0].beside) take(row.id, row.value);
  CHECK(h.at("straight") > 0.0);
  CHECK(h.at("concentric") > h.at("variable"));
  // Beads in gaps and coarse rounds cost time, and each limit that is lifted gives some back.
  CHECK(h.at("slicing-own") > h.at("slicing-no-beads"));
  CHECK(h.at("slicing-offsets") > h.at("variable"));
  CHECK(h.at("variable") >= h.at("lifted-joints"));
  CHECK(h.at("lifted-joints") > h.at("lifted-jerk"));
  CHECK(h.at("lifted-jerk") > h.at("lifted-acceleration"));
  CHECK(h.at("lifted-acceleration") > h.at("lifted-length"));
  CHECK(h.at("variable") > h.at("lifted-straightened"));
  CHECK(h.at("variable-statue") > h.at("lifted-straightened-statue"));
  CHECK(results[1].rows.size() == 9);
  CHECK(results[1].pictures.size() == 1);
}
