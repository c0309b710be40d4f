// Does MPC ever print a layer that is worse than none, or for ever? Random grids, masks, borders, surfaces,
// inks, alphas, horizons and methods: single decisions, each judged anew by the height-change model, and
// whole prints with droplets that vary and a sensor with noise, which must end (the paper's greedy search is
// only shown). A case is a hundred decisions and ten prints.
//   mpc_guard [CASES = 100] [--first CASE = 1] [-o FOLDER and a study's options]
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>

#include "files/json.h"
#include "tests/bench/bench.h"
#include "tests/bench/case_bench.h"
#include "tests/core/control/guard_cases.h"

namespace firn::bench::mpc_guard {

namespace {

using namespace firn;
using namespace firn::control;
using Json = nlohmann::ordered_json;

constexpr std::uint64_t kDecisions = 100, kPrints = 10;  // of a case

Json decisions(std::uint64_t first) {
  int printed = 0;
  Json wrong = Json::array();
  for (std::uint64_t n = first; n < first + kDecisions; ++n) {
    const GuardCase c = random_case(n);
    const Decision d = make_controller(c.setup, c.options)->decide({c.height, int(n % 60), 0, 0.0});
    printed += d.kind == Decision::Kind::kPrint;
    if (!right(c, d))
      wrong.push_back(fmt::format("decision {} ({}, alpha {:.3f}, N = {}): {:.6f} um, none {:.6f} um", n,
                                  c.method, c.alpha, c.options.mpc.horizon, 1e3 * d.objective_mm,
                                  1e3 * d.objective_none_mm));
  }
  return {{"printed", printed}, {"wrong", wrong}};
}

Json prints(std::uint64_t first) {
  std::map<std::string, int> of_method;
  Json endless = Json::object();
  int longest = 0;
  for (std::uint64_t n = first; n < first + kPrints; ++n) {
    GuardCase c = random_case(n);
    RandomStream random(n, Purpose::kInstance);
    if (n % 2) c.alpha = random.uniform(0.02, 0.35), c.options.mpc.alpha = {{1, c.alpha}};
    if (n % 5 == 0) c.options.noise_gate = 0.0;
    const double variation = random.uniform(0.0, 0.4), noise_mm = n % 3 ? 0.0 : random.uniform(0.0, 0.002);
    const int full = int(0.06 / c.setup.model.h1_mm) + 1,
              layers = print_until_end(c, variation, noise_mm, 20 * full);
    ++of_method[c.method];
    longest = std::max(longest, layers);
    if (layers < 0)
      endless[c.method].push_back(
          fmt::format("print {} ({}, alpha {:.3f}, N = {}, variation {:.2f}, sensor {:.2f} um) does not end",
                      n, c.method, c.alpha, c.options.mpc.horizon, variation, 1e3 * noise_mm));
  }
  return {{"of_method", of_method}, {"endless", endless}, {"longest", longest}};
}

}  // namespace

FIRN_BENCH(mpc_guard) {
  int count = 100, from = 1;
  CaseBench bench("mpc_guard", "decisions that are worse than none, and prints that do not end");
  bench.options().option("CASES", count, "").show_default().within(1, 1000000);
  bench.options().option("--first", from, "case").show_default().within(1, 1000000);
  if (const auto code = bench.parse(argc, argv)) return *code;
  Cases cases{"mpc_guard", "", {"decisions and prints"}, {}, {}};
  for (int n = 0; n < count; ++n) cases.seeds.push_back(std::uint64_t(from + n));
  cases.make = [](std::size_t, std::uint64_t seed, int) {
    return Json{{"decisions", decisions((seed - 1) * kDecisions + 1)},
                {"prints", prints((seed - 1) * kPrints + 1)}}
        .dump();
  };
  int code = 0;
  const auto results = bench.results(cases, {std::to_string(count), "--first", std::to_string(from)}, code);
  if (!results) return code;
  std::size_t wrong = 0, failed = 0;
  int printed = 0, longest = 0;
  std::map<std::string, std::pair<int, std::size_t>> of_method;  // prints, endless ones
  for (const CaseBench::Result& r : *results) {
    if (!r.made) {
      fmt::print("{}\n", r.reason);
      ++failed;
      continue;
    }
    const Json of = Json::parse(r.text);
    printed += of["decisions"]["printed"].get<int>();
    for (const Json& line : of["decisions"]["wrong"]) fmt::print("{}\n", line.get<std::string>());
    wrong += of["decisions"]["wrong"].size();
    longest = std::max(longest, of["prints"]["longest"].get<int>());
    for (const auto& [method, n] : of["prints"]["of_method"].items()) of_method[method].first += n.get<int>();
    for (const auto& [method, lines] : of["prints"]["endless"].items()) {
      for (const Json& line : lines) fmt::print("{}\n", line.get<std::string>());
      of_method[method].second += lines.size();
    }
  }
  fmt::print("{} decisions, {} print; {} worse than none or not what they say\n",
             (results->size() - failed) * kDecisions, printed, wrong);
  for (const auto& [method, n] : of_method)
    fmt::print("{:<9} {} of {} prints do not end\n", method, n.second, n.first);
  fmt::print("the longest print that ends has {} layers\n", longest);
  return wrong + failed > 0 ? 1 : 0;
}

}  // namespace firn::bench::mpc_guard
