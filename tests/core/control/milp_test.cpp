// The solver against a mixed integer linear program: minimise the sum of t_c, t_c >= e_c, t_c >= -e_c, e = bare + A u, u
// binary, A column by column from the height-change model. CBC (Debian: coinor-cbc) proves its optimum.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/control/mpc/bound.h"
#include "core/control/mpc/layer_solver.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

namespace fs = std::filesystem;

// What a droplet on `cell` adds to every cell [um].
HeightMap column_um(const StripInstance& in, std::size_t cell) {
  HeightMap h = in.height;
  DropletPattern u(in.setup.grid);
  u.cells[cell] = 1;
  deposition::HeightChange<1>(in.setup.grid, deposition::stencil_of(in.setup.model), in.setup.border).step(h.data(), u.data(), 0);
  for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = 1e3 * (h.cells[c] - in.height.cells[c]);
  return h;
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
        if (const double a = columns[d].cells[c]; in.setup.mask.cells[d] && a != 0.0) out << (sign * a > 0.0 ? " - " : " + ") << std::abs(a) << " u" << d;
      out << " >= " << sign * bare_um << "\n";
    }
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
  const std::string command = "cbc '" + program.string() + "' -sec " + std::to_string(seconds) + " -ratio 0 -allow 0 -solve -solu '" + answer.string() + "' >/dev/null 2>&1";
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
    WARN("skipped: cbc is not installed (Debian: coinor-cbc)");
    return;
  }
  const fs::path folder = fs::path(FIRN_BINARY_DIR) / "milp";
  fs::create_directories(folder);
  int proved = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const StripInstance in = random_instance(seed, 12, 12, false);
    const fs::path program = folder / ("layer" + std::to_string(seed) + ".lp");
    write_program(in, program);
    const double optimum = optimum_um(program, 120);
    LayerProblem problem(in.setup, in.height, in.materials);
    solve_layer(problem, {4, 2, 20, 0.0}, serially);
    const double found = 1e3 * by_model_mm(in, problem.drops(in.setup.grid));
    const double bound = 1e3 * lower_bound(in.setup, in.height, in.materials, 0.0, {4, 40, 0.0}, serially).total_mm;
    std::printf("seed %d: CBC %.6f um, found %.6f um, bound %.6f um\n", int(seed), optimum, found, bound);
    CHECK(bound <= found + 1e-6);
    if (optimum < 0.0) continue;
    ++proved;
    CHECK(found == Approx(optimum).margin(1e-4));
    CHECK(bound <= optimum + 1e-4);
  }
  CHECK(proved > 0);
}
