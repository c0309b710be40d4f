// The shipped states on which layer solvers are measured, and the claims about them.
#include "tests/bench/mpc_instances.h"

#include <catch2/catch.hpp>

#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "files/digest.h"
#include "files/json.h"

using namespace firn;
using namespace firn::control::mpc;

namespace {

const std::string kFolder = FIRN_SOURCE_DIR "/tests/bench/instances";

}  // namespace

TEST_CASE("The instances are what their generator makes, and files and best layers have their checksums") {
  const auto table = nlohmann::json::parse(bench::instance_bytes(kFolder, "best.json"));
  CHECK(table["target"]["sha256"] == sha256_hex(bench::instance_bytes(kFolder, "target.npy")));
  for (const std::string name : bench::kInstances) {
    INFO(name);
    const auto bytes = bench::instance_bytes(kFolder, name + ".npy");
    CHECK(table[name]["sha256"] == sha256_hex(bytes));
    CHECK(table[name]["best_sha256"] == sha256_hex(bench::instance_bytes(kFolder, "best/" + name + ".npy")));
    CHECK(bytes == bench::float32_npy(bench::make_instance(name)));
  }
}

TEST_CASE("The best layers known cost what is said, no less than the bound, and the solver comes near both") {
  const auto table = nlohmann::json::parse(bench::instance_bytes(kFolder, "best.json"));
  const control::Setup setup = bench::setup_of(100);
  for (const std::string name : bench::kInstances) {
    INFO(name);
    const HeightMap h = bench::read_instance(kFolder, name);
    const DropletPattern best = bench::best_known(kFolder, name);
    const double best_um = table[name]["best_um"], bound_um = table[name]["bound_um"];
    CHECK(bench::mean_error_um(setup, h, best) == Approx(best_um).epsilon(1e-9));
    CHECK(best.total() == table[name]["droplets"].get<std::int64_t>());
    CHECK(bound_um <= best_um);
    CHECK(bound_um > 0.998 * best_um);

    LayerProblem problem(setup, h, {});
    problem.set_drops(DropletPattern(setup.grid, 1));
    solve_layer(problem, {2, 1, 2, 1e-6}, serially);
    const double found_um = bench::mean_error_um(setup, h, problem.drops(setup.grid));
    CHECK(found_um >= bound_um);
    CHECK(found_um < 1.003 * best_um);

    const LowerBound b = lower_bound(setup, h, {}, 1e-3 * best_um * double(h.size()), {1, 4, 1e-6}, serially);
    const double proved_um = 1e3 * b.total_mm / double(h.size());
    CHECK(proved_um <= best_um * (1.0 + 1e-9));
    CHECK(proved_um > 0.996 * best_um);
  }
}
