#include "cli/decide_command.h"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

#include "config/error.h"
#include "config/include.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/inputs/targets.h"
#include "runs/folder/run_folder.h"
#include "studies/edge/edge_bound.h"
#include "tests/files/record/scratch.h"
#include "tests/support/skip.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

// A folder with a surface 7 to 15 um below its target, 12 x 9 cells.
struct States {
  explicit States(const char* name) : scratch(name) {
    const GridSpec g{12, 9};
    RandomStream random(1, Purpose::kTest);
    HeightMap height(g);
    for (double& h : height.cells) h = float(0.1 - random.uniform(0.007, 0.015));
    o.height = put("height.npy", to_npy(height));
    o.target = put("target.npy", to_npy(HeightMap(g, 0.1)));
    o.json = true;
    const std::string header = "\x93NUMPY\x01" + std::string(1, 0) + "\x76" + std::string(1, 0) +
                               "{'descr': '<f4', 'fortran_order': False, 'shape': (9, 12), }";
    std::string text = header + std::string(128 - header.size() - 1, ' ') + "\n";
    for (const double h : height.cells) {
      const float single = float(h);
      text.append(reinterpret_cast<const char*>(&single), sizeof single);
    }
    single = put("single.npy", {reinterpret_cast<const std::byte*>(text.data()),
                                reinterpret_cast<const std::byte*>(text.data()) + text.size()});
  }
  std::string put(const char* name, const std::vector<std::byte>& bytes) {
    write_file(scratch / name, bytes);
    return (scratch / name).string();
  }
  Scratch scratch;
  DecideOptions o;
  std::string single;
};

}  // namespace

TEST_CASE(
    "firn decide tells the same of float32 and float64 surfaces, and better methods and longer horizons find "
    "better layers") {
  States s("decide-methods");
  double last = 1.0;
  for (const char* method : {"greedy", "descent", "strip-dp"}) {
    s.o.method = method;
    auto json = nlohmann::json::parse(decide(s.o));
    CHECK(json["decision"] == "print");
    CHECK(json["objective_mm"].get<double>() < json["objective_none_mm"].get<double>());
    DecideOptions single = s.o;
    single.height = s.single;
    auto same = nlohmann::json::parse(decide(single));
    for (const char* cost : {"cpu_s", "peak_bytes"}) {
      json.erase(cost);
      same.erase(cost);
    }
    CHECK(json == same);
    last = json["objective_mm"];
  }
  for (const int horizon : {2, 3}) {
    s.o.horizon = horizon;
    const double now = nlohmann::json::parse(decide(s.o))["objective_mm"];
    CHECK(now <= last);
    last = now;
  }
  s.o.json = false;
  CHECK_THAT(decide(s.o), Contains("um, after 3 layers, the next with "));
  s.o.output = (s.scratch / "u.npy").string();
  decide(s.o);
  CHECK(mask_from_npy(read_bytes(s.o.output, "u"), GridSpec{12, 9}, "u").size() == 108);
}

TEST_CASE(
    "firn decide proves a bound for one layer at any alpha and says that it cannot for several layers or "
    "droplets") {
  States s("decide-bound");
  s.o.method = "strip-dp";
  s.o.bound = true;
  for (const double alpha : {0.2, 0.5, 1.0}) {
    s.o.alpha = alpha;
    const auto json = nlohmann::json::parse(decide(s.o));
    CHECK(json["gap"].get<double>() >= 0.0);
    CHECK(json["gap"].get<double>() < 0.1);
    CHECK(json["lower_bound_mm"].get<double>() <= json["objective_mm"].get<double>());
  }
  for (const auto& change : std::vector<std::function<void(DecideOptions&)>>{
           [](DecideOptions& o) { o.horizon = 2; },
           [](DecideOptions& o) { o.overrides = {"control.scheme=smf"}; },
           [](DecideOptions& o) { o.overrides = {"control.mpc.max_drops=2"}; }}) {
    DecideOptions o = s.o;
    change(o);
    CHECK_THROWS_WITH(decide(o), Contains("horizon = 1 and one droplet per cell only"));
  }
  s.o.bound = false;
  s.o.certificate = "c.npy";
  CHECK_THROWS_WITH(decide(s.o), Contains("--certificate"));
}

TEST_CASE(
    "firn decide gives the same answer and bound on any number of threads, and tells its memory, and squares "
    "have no bound") {
  States s("decide-threads");
  s.o.method = "certified";
  s.o.bound = true;
  const auto one = nlohmann::json::parse(decide(s.o));
  CHECK(one["peak_bytes"].get<double>() > 1e6);
  for (const int threads : {0, 2, 5}) {
    s.o.threads = threads;
    const auto other = nlohmann::json::parse(decide(s.o));
    for (const char* key : {"objective_mm", "droplets", "lower_bound_mm", "iterations"})
      CHECK(other[key] == one[key]);
  }
  s.o.overrides = {"control.mpc.error=square"};
  CHECK_THROWS_WITH(decide(s.o), Contains("error = absolute"));
}

TEST_CASE(
    "firn decide refuses what is no state by name: shapes, kinds of numbers, cells that are not finite, "
    "values out of range") {
  States s("decide-bad");
  const auto refuses = [&](const char* what, const std::function<void(DecideOptions&)>& change) {
    DecideOptions o = s.o;
    change(o);
    CAPTURE(what);
    CHECK_THROWS_WITH(decide(o), Contains(what));
    try {
      decide(o);
    } catch (const std::exception& e) {  // both end the command with exit code 2
      CHECK((dynamic_cast<const UsageError*>(&e) || dynamic_cast<const ConfigError*>(&e)));
    }
  };
  const GridSpec g{12, 9};
  HeightMap holes(g, 0.09);
  holes.at(3, 2) = std::numeric_limits<double>::quiet_NaN();
  const std::string hole = s.put("hole.npy", to_npy(holes)),
                    other = s.put("other.npy", to_npy(HeightMap(GridSpec{9, 12}, 0.1)));
  const std::string nothing = s.put("nothing.npy", to_npy(Mask(g, 0))),
                    text = s.put("text.npy", std::vector<std::byte>(50));
  refuses("no such file", [](DecideOptions& o) { o.height = "nowhere.npy"; });
  refuses("text.npy", [&](DecideOptions& o) { o.height = text; });
  refuses("text.npy", [&](DecideOptions& o) { o.check_certificate = text; });
  refuses("(12, 9)", [&](DecideOptions& o) { o.target = other; });
  refuses("height.npy", [&](DecideOptions& o) { o.mask = o.height; });
  refuses("mask", [&](DecideOptions& o) { o.mask = nothing; });
  refuses("(3, 2)", [&](DecideOptions& o) { o.height = hole; });
  refuses("(3, 2)", [&](DecideOptions& o) { o.target = hole; });
  refuses("control.mpc.alpha", [](DecideOptions& o) { o.alpha = 1.5; });
  refuses("alpha", [](DecideOptions& o) { o.alpha = 0.0; });
  refuses("alpha", [](DecideOptions& o) { o.alpha = std::numeric_limits<double>::quiet_NaN(); });
  refuses("control.mpc.horizon", [](DecideOptions& o) { o.horizon = 0; });
  refuses("horizon = 9", [](DecideOptions& o) { o.horizon = 9; });
  refuses("strip_dp", [](DecideOptions& o) { o.method = "strips"; });
  refuses("--bound-rows", [](DecideOptions& o) {
    o.bound = true;
    o.bound_rows = 9;
  });
  refuses("horizon = 1", [](DecideOptions& o) {
    o.bound = true;
    o.horizon = 2;
  });
  refuses("alpha = 1 only", [](DecideOptions& o) {
    o.bound = true;
    o.alpha = 0.5;
    o.certificate = "out.npy";
  });
  refuses("geometry.shape", [](DecideOptions& o) { o.overrides = {"geometry.shape=pipe_junction"}; });

  Mask mask(g, 1);  // a hole off the part is bare ground
  mask.at(3, 2) = 0;
  s.o.height = hole;
  s.o.mask = s.put("mask.npy", to_npy(mask));
  CHECK(nlohmann::json::parse(decide(s.o))["decision"] == "print");
}

TEST_CASE(
    "firn decide --edge-bound tells the least overspill at the surface's own mean error, beside its own") {
  if (!has_edge_solver()) {
    skip("cbc", "cbc is not installed (Debian: coinor-cbc)");
    return;
  }
  States s("decide-edge");
  const GridSpec g{5, 5};
  Mask mask(g);
  HeightMap target(g, 0.0), height(g, 0.0);
  mask.at(2, 2) = 1;
  target.at(2, 2) = 0.4;
  height.at(2, 2) = 0.3;
  height.at(1, 2) = 0.04;
  s.o.height = s.put("low.npy", to_npy(height));
  s.o.target = s.put("cell.npy", to_npy(target));
  s.o.mask = s.put("one.npy", to_npy(mask));
  s.o.edge_bound = true;
  const auto json = nlohmann::json::parse(decide(s.o));
  CHECK(json["mean_abs_error_mm"].get<double>() == Approx(0.1));
  CHECK(json["overspill_pct"].get<double>() == Approx(10.0));
  // One cell gives its neighbours 4 (h2 + h3) of every h1 that it keeps, and has 3/4 of its height.
  CHECK(json["edge_bound_pct"].get<double>() == Approx(75.0 * 4 * (0.6 + 0.2) / 4.4));
}
