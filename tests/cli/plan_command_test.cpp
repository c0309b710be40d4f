#include "cli/plan_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "config/error.h"
#include "files/exit_codes.h"
#include "files/path/trajectory_file.h"
#include "files/usage_error.h"

using namespace firn;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

const std::string kPlanSource = FIRN_SOURCE_DIR;

fs::path folder() {
  const fs::path f = fs::path(FIRN_BINARY_DIR) / "tests" / "plan_command";
  fs::create_directories(f);
  return f;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

PlanCommandOptions fig42() {
  PlanCommandOptions o;
  o.paths = kPlanSource + "/experiments/barnett-fig42.csv";
  o.machine = kPlanSource + "/labs/cobra600.toml";
  o.origin_mm = {354.0, -46.0};
  o.threads = 1;
  o.json = true;
  return o;
}

struct Row {
  double t, x, y, q1, q2;
};
std::vector<Row> rows_of(const fs::path& csv) {
  std::istringstream in(text_of(csv));
  std::string line;
  std::getline(in, line);
  REQUIRE(line == "t_s,x_mm,y_mm,joint_1_rad,joint_2_rad");
  std::vector<Row> rows;
  for (Row r; std::getline(in, line) &&
              std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &r.t, &r.x, &r.y, &r.q1, &r.q2) == 5;)
    rows.push_back(r);
  return rows;
}

std::size_t files_in(const fs::path& f) {
  return std::size_t(std::distance(fs::directory_iterator(f), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("The CSV of the test path keeps every limit, stays on the path and moves the arm where it says") {
  PlanCommandOptions o = fig42();
  o.csv = folder() / "fig42.csv";
  o.output = folder() / "fig42.traj";
  o.plot = folder() / "fig42.svg";
  REQUIRE(run_plan(o) == kOk);
  const std::vector<Row> rows = rows_of(o.csv);
  REQUIRE(rows.size() > 300);
  const double h = rows[1].t - rows[0].t;
  CHECK(h == Approx(0.016));
  CHECK(rows.back().t <= 5.268 + h);  // 1.02 of the reference time, in whole ticks
  CHECK(std::hypot(rows.front().x - 46.0, rows.front().y) < 1e-6);
  CHECK(std::hypot(rows.back().x - 46.0, rows.back().y) < 1e-6);
  for (const Row& r : rows) {  // the arm's own geometry, written out
    const double x = 325.0 * std::cos(r.q1) + 275.0 * std::cos(r.q1 + r.q2),
                 y = 325.0 * std::sin(r.q1) + 275.0 * std::sin(r.q1 + r.q2);
    REQUIRE(std::hypot(x - 354.0 - r.x, y + 46.0 - r.y) < 1e-6);
  }
  // Rates, accelerations and jerks by differences of neighbouring rows: speed has the largest norm of (x, y).
  using Value = double Row::*;
  const auto difference = [&](Value v, std::size_t n, int order) {
    const auto d = [&](std::size_t k) { return rows[n - k].*v; };
    return (order == 1   ? d(0) - d(1)
            : order == 2 ? d(0) - 2 * d(1) + d(2)
                         : d(0) - 3 * d(1) + 3 * d(2) - d(3)) /
           std::pow(h, order);
  };
  const double degree = std::acos(-1.0) / 180.0;
  for (const auto& [order, total, j1, j2] :
       {std::tuple{1, 125.0, 33.0, 39.0}, {2, 500.0, 165.0, 195.0}, {3, 4000.0, 1320.0, 1560.0}})
    for (std::size_t n = 3; n < rows.size(); ++n) {
      REQUIRE(std::hypot(difference(&Row::x, n, order), difference(&Row::y, n, order)) <= 1.001 * total);
      REQUIRE(std::abs(difference(&Row::q1, n, order)) <= 1.001 * j1 * degree);
      REQUIRE(std::abs(difference(&Row::q2, n, order)) <= 1.001 * j2 * degree);
    }

  TrajectoryReader reader{fs::path(o.output)};
  const auto path = reader.next();
  REQUIRE(path);
  CHECK(path->trajectory.samples() == rows.size());
  CHECK(path->trajectory.positions[4 * 100] == rows[100].q1);
  for (const LimitRatio& l : path->trajectory.certificate.limits) CHECK(l.ratio <= 1.001);
  CHECK(path->trajectory.certificate.limits.size() == 9);
  CHECK_FALSE(reader.next());
  CHECK(text_of(o.plot).starts_with("<svg"));
}

TEST_CASE(
    "JSON paths with tools, speed limits and pulses are planned, and one and two threads write the same "
    "bytes") {
  PlanCommandOptions o = fig42();
  o.paths = kPlanSource + "/experiments/measure-square.json";
  o.output = folder() / "one.traj";
  o.csv = folder() / "square.csv";
  REQUIRE(run_plan(o) == kOk);
  const std::string first = text_of(o.output);
  o.threads = 2;
  o.output = folder() / "two.traj";
  REQUIRE(run_plan(o) == kOk);
  CHECK(first == text_of(o.output));
  TrajectoryReader reader{fs::path(o.output)};
  std::size_t paths = 0;
  while (const auto p = reader.next()) {
    ++paths;
    CHECK(p->layer == 4);
    CHECK(p->kind == std::array{PathKind::kBoundary, PathKind::kFill, PathKind::kMeasurement}[paths - 1]);
    if (p->kind == PathKind::kMeasurement)
      CHECK(p->trajectory.certificate.duration_s > 20.0 / 25.0 + 20.0 / 50.0);
  }
  CHECK(paths == 3);
}

TEST_CASE("Pulses stand in a list per path and count the volume") {
  const fs::path file = folder() / "line.json";
  std::ofstream(file)
      << R"({"paths": [{"width_mm": 1.5, "layer_height_mm": 0.25, "points": [[0, 0], [100, 0]]},
    {"width_mm": 3, "layer_height_mm": 0.25, "points": [[0, 5], [100, 5]]}]})";
  PlanCommandOptions o = fig42();
  o.paths = file;
  o.pulses = folder() / "line.pulses.csv";
  REQUIRE(run_plan(o) == kOk);
  std::istringstream in(text_of(o.pulses));
  std::string line;
  std::getline(in, line);
  CHECK(line == "path,list,start_s,tick");
  std::array<int, 3> count{};
  int before = -1, path_before = 0;
  while (std::getline(in, line)) {
    int path = 0, list = 0, tick = 0;
    double start = 0.0;
    REQUIRE(std::sscanf(line.c_str(), "%d,%d,%lf,%d", &path, &list, &start, &tick) == 4);
    REQUIRE((path != path_before || tick > before));
    before = tick;
    path_before = path;
    ++count[std::size_t(path)];
  }
  CHECK(std::abs(count[1] - 150) <= 1);
  CHECK(std::abs(count[2] - 300) <= 1);
}

TEST_CASE("A tolerance of 0 keeps a line into dense samples, which ramps alone leave by 30 um") {
  PlanCommandOptions o = fig42();
  o.origin_mm = {400.0, 0.0};
  o.paths = folder() / "line_into_samples.csv";
  {
    std::ofstream out(o.paths);
    out << "x_mm,y_mm\n0,0\n10,0\n" << std::fixed;
    for (int k = 1; k < 100; ++k) out << 10.0 + 0.05 * k << ',' << 2.5e-5 * k * k << '\n';
  }
  o.csv = folder() / "line_into_samples_driven.csv";
  o.tolerance_mm = 0.0;
  REQUIRE(run_plan(o) == kOk);
  double off_mm = 0.0;
  for (const Row& r : rows_of(o.csv))
    off_mm = std::max(off_mm, std::abs(r.y - (r.x > 10.0 ? 0.01 * (r.x - 10.0) * (r.x - 10.0) : 0.0)));
  CHECK(off_mm < 3e-4);
}

TEST_CASE("A path that cannot be planned is named with point, value and limit, and nothing is written") {
  const fs::path where = folder() / "refused";
  fs::remove_all(where);
  fs::create_directories(where);
  PlanCommandOptions o = fig42();
  o.paths = folder() / "far.csv";
  std::ofstream(o.paths) << "x_mm,y_mm\n0,0\n10,0\n\n0,0\n300,0\n";
  o.output = where / "x.traj";
  o.csv = where / "x.csv";
  o.json = false;
  CHECK(run_plan(o) == kFailed);
  CHECK(files_in(where) == 0);
  o.paths = folder() / "bad.csv";
  std::ofstream(o.paths) << "x_mm,y_mm\n0,0\n10,0\n\n0,zero\n";
  CHECK_THROWS_WITH(run_plan(o), Contains("bad.csv:5") && Contains("y_mm = zero"));
  CHECK(files_in(where) == 0);
}

TEST_CASE("Options that do not fit are refused by name before anything is written") {
  const auto refused = [](auto change) {
    PlanCommandOptions o = fig42();
    change(o);
    try {
      run_plan(o);
    } catch (const UsageError& e) {
      return std::string(e.what());
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK_THAT(refused([](auto& o) { o.method = "fast"; }), Contains("--method fast") && Contains("certified"));
  CHECK_THAT(refused([](auto& o) { o.tolerance_mm = -1; }),
             Contains("--tolerance -1") && Contains("[0, 10] mm"));
  CHECK_THAT(refused([](auto& o) { o.tolerance_mm = 99; }),
             Contains("--tolerance 99") && Contains("[0, 10] mm"));
  CHECK_THAT(refused([](auto& o) { o.fill_mm_s = 0; }), Contains("--fill-speed 0"));
  CHECK_THAT(refused([](auto& o) { o.curvature_ramp_mm = 0; }), Contains("--ramp 0"));
  CHECK_THAT(refused([](auto& o) { o.origin_mm = {1e9, 0}; }), Contains("--origin"));
  CHECK_THAT(refused([](auto& o) { o.corner = "loop"; }), Contains("--corner") && Contains("aerosol"));
  CHECK_THAT(refused([](auto& o) { o.machine = "none.toml"; }), Contains("none.toml"));
  CHECK_THAT(refused([](auto& o) { o.csv = "no/such/folder/x.csv"; }), Contains("no/such/folder/x.csv"));
  CHECK_THAT(refused([](auto& o) {
               o.plot = folder() / "x.svg";
               o.plot_path = 7;
             }),
             Contains("--plot-path 7") && Contains("1 path"));
  CHECK_THAT(refused([](auto& o) { o.output = o.paths; }),
             Contains("would take the place of") && Contains("fig42.csv"));
  CHECK_THAT(refused([](auto& o) { o.gcode = kPlanSource + "/labs/../labs/cobra600.toml"; }),
             Contains("would take the place of") && Contains("cobra600.toml"));
  CHECK_THAT(refused([](auto& o) {
               o.csv = folder() / "new.csv";
               o.plot = folder() / "." / "new.csv";
             }),
             Contains("new.csv: would take the place of"));
  const auto aerosol = [](PlanCommandOptions& o) {
    o.machine = kPlanSource + "/labs/aerosol.toml";
    o.paths = kPlanSource + "/experiments/thompson-fig7.json";
    o.origin_mm.clear();
  };
  CHECK_THAT(refused([&](auto& o) {
               aerosol(o);
               o.method = "thesis";
             }),
             Contains("--method") && Contains("aerosol"));
  CHECK_THAT(refused([&](auto& o) {
               aerosol(o);
               o.pulses = "x";
             }),
             Contains("--pulses"));
}

TEST_CASE("Method optimal says before a long path what it may take, other methods and short paths nothing") {
  const auto warning = slow_path_warning("optimal", "job.csv:2", 10000);
  REQUIRE(warning);
  CHECK_THAT(*warning, Contains("job.csv:2") && Contains("50 s and 0.3 GB") && Contains("10000 points"));
  CHECK_FALSE(slow_path_warning("optimal", "job.csv:2", 1000));
  CHECK_FALSE(slow_path_warning("certified", "job.csv:2", 1000000));
}

TEST_CASE("An aerosol machine's job becomes a trajectory file of its stage") {
  PlanCommandOptions o = fig42();
  o.machine = kPlanSource + "/labs/aerosol.toml";
  o.paths = kPlanSource + "/experiments/thompson-fig7.json";
  o.origin_mm.clear();
  o.output = folder() / "fig7.traj";
  REQUIRE(run_plan(o) == kOk);
  TrajectoryReader reader{fs::path(o.output)};
  CHECK(reader.head().axis_units == std::vector<std::string>{"mm", "mm"});
  const auto path = reader.next();
  REQUIRE(path);
  CHECK(path->trajectory.samples() > 1000);
  CHECK_FALSE(reader.next());
}
