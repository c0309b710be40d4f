// The lab of docs/write-a-lab.md: its rows stand in copies of the tables, which this program is linked with.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "config/error.h"
#include "config/labs.h"
#include "print/folder/run_report.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "print/simulated/memory_print.h"
#include "report/run/report_page.h"
#include "runs/folder/run_folder.h"
#include "tests/files/record/scratch.h"

using namespace firn;

namespace {

std::string file(const std::string& path) {
  std::ifstream in(std::string(FIRN_SOURCE_DIR) + "/" + path);
  REQUIRE(in.good());
  return {std::istreambuf_iterator<char>(in), {}};
}

Experiment plate() {
  return parse_experiment(
      "[lab]\nkind = \"plate\"\n[control]\nscheme = \"open_loop\"\n[grid]\nnx = 8\nny = 6\n", "plate.toml");
}

}  // namespace

TEST_CASE("The page of labs names every existing file that the change edits") {
  const std::string page = file("docs/write-a-lab.md");
  CHECK(page.find("](../tests/examples/plate-lab.patch)") != std::string::npos);
  std::istringstream patch(file("tests/examples/plate-lab.patch"));
  const std::string mark = "--- a/";
  int edited = 0;
  for (std::string line; std::getline(patch, line);) {
    if (!line.starts_with(mark)) continue;
    INFO(line);
    CHECK(page.find("`" + line.substr(mark.size()) + "`") != std::string::npos);
    ++edited;
  }
  CHECK(edited >= 5);
}

TEST_CASE("A lab that the page's change adds has its own keys, processes and checks") {
  const Experiment e = plate();
  CHECK(lab_of(e).name == "plate");
  CHECK(dump(parse_experiment(dump(e), "dump")) == dump(e));
  CHECK(dump(e).find("kind = \"plate\"") != std::string::npos);
  std::vector<std::string> names;
  for (const NamedMaker& m : taking_part(full_product(), e)) names.emplace_back(info(m.id).name);
  CHECK(names == std::vector<std::string>{"scheduler", "surface_mapper", "controller", "stage", "jet",
                                          "laser_profiler", "lamp", "safety"});
  CHECK_THROWS_AS(parse_experiment("[lab]\nkind = \"plate\"\n[model]\nh1_mm = 0.004\n", "plate.toml"),
                  ConfigError);
  CHECK_THROWS_WITH(parse_experiment("[lab]\nkind = \"plate\"\n", "plate.toml"),
                    Catch::Contains("open loop"));
}

TEST_CASE("A lab that the page's change adds prints one layer in memory and in process, with a report") {
  const Experiment e = plate();
  const Blobs inputs = make_inputs(full_product(), e, "");
  const MemoryPrintReport print = print_in_memory(full_product(), e, inputs);
  INFO(print.result.reason);
  CHECK(print.result.status == 0);
  CHECK(print.result.layers == 1);
  CHECK(print.droplets == 8 * 6);

  const test::Scratch scratch("plate-lab");
  const runs::RunFolder run = runs::RunFolder::create(scratch / "runs", e, inputs, {"test"});
  const LabRunReport report = run_in_lab(full_product(), run, {});
  INFO(report.result.reason);
  CHECK(report.result.status == 0);
  const report::RunData data = run_data(full_product(), run.path());
  REQUIRE(data.layers.size() >= 1);
  CHECK(data.layers.back().drops_total == 8 * 6);
  CHECK(report::report_page({{data, ""}}, {}).find("Final surfaces") != std::string::npos);
}
