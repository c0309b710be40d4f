// The solver against a mixed integer linear program: minimise the sum of t_c, t_c >= e_c, t_c >= -e_c, e =
// bare + A u, u binary, A column by column from the height-change model. CBC (Debian: coinor-cbc) proves its
// optimum. The relaxation knows nothing of |e| as long as droplets may be halved, so the states are printed
// layers with errors of up to 0.6 to 3 um on them, and each t_c is at least its value for the best
// neighbours with and without the cell's own droplet.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "tests/core/control/strip_instances.h"
#include "tests/support/skip.h"

using namespace firn;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

namespace fs = std::filesystem;

// Height that a droplet on `cell` adds to every cell [um].
HeightMap column_um(const StripInstance& in, std::size_t cell) {
  HeightMap h = in.height;
  DropletPattern u(in.setup.grid);
  u.cells[cell] = 1;
  deposition::HeightChange<1>(in.setup.grid, deposition::stencil_of(in.setup.model), in.setup.border)
      .step(h.data(), u.data(), 0);
  for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = 1e3 * (h.cells[c] - in.height.cells[c]);
  return h;
}

// A printed layer is wanted, with an error on every cell; holes in the part as they come.
StripInstance noisy_layer(std::uint64_t seed, double error_mm) {
  StripInstance in = random_instance(seed, 12, 12, false);
  RandomStream random(seed, Purpose::kInstance);
  in.setup.model = {};
  in.setup.target = in.height;
  const DropletPattern u = random_drops(in, random);
  deposition::HeightChange<1>(in.setup.grid, deposition::stencil_of(in.setup.model), in.setup.border)
      .step(in.setup.target.data(), u.data(), 0);
  for (double& t : in.setup.target.cells) t += random.uniform(-error_mm, error_mm);
  return in;
}

// Least |error| of a cell for any droplets around it [um]. @param others heights that those add
double min_um(double error, const std::vector<double>& others) {
  double least = 1e9;
  for (unsigned bits = 0; bits < 1u << others.size(); ++bits) {
    double e = error;
    for (std::size_t q = 0; q < others.size(); ++q) e += bits >> q & 1 ? others[q] : 0.0;
    least = std::min(least, std::abs(e));
  }
  return least;
}

void write_program(const StripInstance& in, const fs::path& file) {
  std::ofstream out(file);
  out.precision(12);
  const std::size_t n = in.height.size();
  std::vector<HeightMap> columns;
  for (std::size_t c = 0; c < n; ++c) columns.push_back(column_um(in, c));
  out << "Minimize\n obj:";
  for (std::size_t c = 0; c < n; ++c)
    if (in.setup.mask.cells[c]) out << " + t" << c << "\n";
  out << "Subject To\n";
  for (std::size_t c = 0; c < n; ++c) {
    if (!in.setup.mask.cells[c]) continue;
    const double bare_um = 1e3 * (in.height.cells[c] - in.setup.target.cells[c]);
    for (const int sign : {1, -1}) {
      out << (sign > 0 ? " over" : " under") << c << ": t" << c;
      for (std::size_t d = 0; d < n; ++d)
        if (const double a = columns[d].cells[c]; in.setup.mask.cells[d] && a != 0.0)
          out << (sign * a > 0.0 ? " - " : " + ") << std::abs(a) << " u" << d;
      out << " >= " << sign * bare_um << "\n";
    }
    std::vector<double> others;
    for (std::size_t d = 0; d < n; ++d)
      if (d != c && in.setup.mask.cells[d] && columns[d].cells[c] != 0.0)
        others.push_back(columns[d].cells[c]);
    const double without = min_um(bare_um, others), with = min_um(bare_um + columns[c].cells[c], others);
    out << " own" << c << ": t" << c << (without > with ? " + " : " - ") << std::abs(without - with) << " u"
        << c << " >= " << without << "\n";
  }
  out << "Binary\n";
  for (std::size_t c = 0; c < n; ++c)
    if (in.setup.mask.cells[c]) out << " u" << c << "\n";
  out << "End\n";
}

// The optimum [um], or a negative number when CBC did not prove one in time.
double optimum_um(const fs::path& program, int seconds) {
  const fs::path answer = program.string() + ".txt";
  fs::remove(answer);
  const std::string command = "cbc '" + program.string() + "' -sec " + std::to_string(seconds) +
                              " -ratio 0 -allow 0 -solve -solu '" + answer.string() + "' >/dev/null 2>&1";
  if (std::system(command.c_str()) != 0) return -1.0;
  std::ifstream in(answer);
  std::string word, dash, objective, value;
  in >> word >> dash >> objective >> value;
  double optimum = -1.0;
  if (word == "Optimal") in >> optimum;
  return optimum;
}

}  // namespace

TEST_CASE("a MILP solver proves the same optimum on 12 x 12, and no bound is above it") {
  if (std::system("command -v cbc >/dev/null 2>&1") != 0) {
    skip("cbc", "cbc is not installed (Debian: coinor-cbc)");
    return;
  }
  const fs::path folder = fs::path(FIRN_BINARY_DIR) / "milp";
  fs::create_directories(folder);
  int proved = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const StripInstance in = noisy_layer(seed, 0.0006 * double(seed));
    const fs::path program = folder / ("layer" + std::to_string(seed) + ".lp");
    write_program(in, program);
    const double optimum = optimum_um(program, 60);
    LayerProblem problem(in.setup, in.height, in.materials);
    solve_layer(problem, {4, 2, 20, 0.0}, serially);
    const double found = 1e3 * by_model_mm(in, problem.drops(in.setup.grid));
    const double bound =
        1e3 * lower_bound(in.setup, in.height, in.materials, 0.0, {4, 40, 0.0}, serially).total_mm;
    INFO("seed " << seed << ": CBC " << optimum << " um, found " << found << " um, bound " << bound << " um");
    CHECK(bound <= found + 1e-6);
    if (optimum < 0.0) continue;
    ++proved;
    CHECK(found == Approx(optimum).margin(1e-4));
    CHECK(bound <= optimum + 1e-4);
  }
  CHECK(proved == 5);
}
