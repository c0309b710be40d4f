// The experiments that are shipped.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "config/include.h"
#include "config/labs.h"
#include "core/grid/npy.h"
#include "core/slice/paths/print_paths.h"
#include "print/labs/full_product.h"
#include "studies/compare/study_runner.h"

using namespace firn;
namespace fs = std::filesystem;

namespace {

const fs::path kExperiments = fs::path(FIRN_SOURCE_DIR) / "experiments";

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A mask of some cells, or layers of paths.
void check_part(const Experiment& e, const Blobs& inputs) {
  if (prints_paths(e))
    CHECK(slice::decode_print_paths(blob(inputs, "paths").bytes).layers.size() >= 10);
  else
    CHECK(mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask").count() >= 40);
}

}  // namespace

TEST_CASE("Every shipped experiment is valid, has a part and bears its file's name") {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kExperiments)) {
    if (entry.path().extension() != ".toml") continue;
    INFO(entry.path().string());
    const Experiment e = load_experiment(entry.path());
    CHECK(e.run.name == entry.path().stem().string());
    check_part(e, make_inputs(full_product(), e, kExperiments));
    ++count;
  }
  CHECK(count >= 5);
}

TEST_CASE("Every shipped study resolves, and each of its parts covers cells of the grid") {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kExperiments / "studies")) {
    if (entry.is_directory()) continue;  // its parts
    INFO(entry.path().string());
    const StudyPlan plan =
        plan_study(load_study(entry.path()), entry.path().parent_path(),
                   study_lab_of(load_study(entry.path()), entry.path().parent_path()), entry.path().string());
    CHECK(plan.study.name == entry.path().stem().string());
    for (std::size_t n = 0; n < plan.inputs.size(); ++n) check_part(plan.experiments[n], *plan.inputs[n]);
    ++count;
  }
  CHECK(count >= 1);
}

TEST_CASE("The shipped height map is what scripts/make_height_map.py writes") {
  const fs::path written = fs::path(FIRN_BINARY_DIR) / "test-height-map.png";
  const std::string command =
      "python3 '" + std::string(FIRN_SOURCE_DIR) + "/scripts/make_height_map.py' '" + written.string() + "'";
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(bytes_of(written) == bytes_of(kExperiments / "height_map.png"));
  fs::remove(written);
}

TEST_CASE("The shipped relief has the formula's height at its centre and corners outside the part") {
  const Experiment e = load_experiment(kExperiments / "height-map.toml");
  const Blobs inputs = make_inputs(full_product(), e, kExperiments);
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  CHECK(target.at(20, 20) == Approx(0.3 * 0.7).epsilon(0.03));  // 0.5 + 0.2 at r = 0
  CHECK(target.at(0, 0) == 0.0);
  CHECK(blob(inputs, "image").bytes.size() == fs::file_size(kExperiments / "height_map.png"));
}
