// The small pictures of the list of runs: what they show, and that each is drawn once.
#include <catch2/catch.hpp>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "core/grid/random.h"
#include "files/text_file.h"
#include "page/thumbnail.h"
#include "page/thumbnails.h"
#include "print/labs/full_product.h"
#include "report/draw/heat_map.h"
#include "runs/folder/run_lock.h"
#include "tests/page/served_run.h"
#include "tests/page/web_client.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using firn::test::Served;
using firn::test::WebClient;

namespace {

HeightMap random_map(int nx, int ny, double pitch_y_mm) {
  HeightMap map(GridSpec{nx, ny, 0.25, pitch_y_mm, 0.0, 0.0}, 0.0);
  RandomStream random(7, Purpose::kTest);
  for (double& mm : map.cells) mm = 1e-6 * double(random.below(20'000)) - 0.01;
  return map;
}

}  // namespace

TEST_CASE("a small map has the proportions of the map's millimetres") {
  const HeightMap small = page::small_map(random_map(400, 100, 0.5));
  CHECK(small.spec.nx == page::kThumbnailPixels);
  CHECK(small.spec.ny == page::kThumbnailPixels / 2);
}

TEST_CASE("a small map has the mean of a map whose cells it divides") {
  const HeightMap map = random_map(2 * page::kThumbnailPixels, 3 * page::kThumbnailPixels, 0.25 / 1.5);
  const HeightMap small = page::small_map(map);
  double all = 0.0, few = 0.0;
  for (const double mm : map.cells) all += mm / double(map.size());
  for (const double mm : small.cells) few += mm / double(small.size());
  CHECK(few == Approx(all).margin(1e-12));
}

TEST_CASE("cells that were not seen are left out of a small map's means") {
  HeightMap map(GridSpec{2 * page::kThumbnailPixels, 2, 0.25, 0.25, 0.0, 0.0}, kNotMeasured);
  map.at(1, 0) = 0.003;
  const HeightMap small = page::small_map(map);
  CHECK(small.at(0, 0) == 0.003);
  CHECK(std::isnan(small.at(1, 0)));
}

TEST_CASE("errors are blue where the surface is too low, white without error, orange where it is too high") {
  HeightMap error(GridSpec{4, 1, 0.25, 0.25, 0.0, 0.0}, 0.0);
  error.cells = {-0.005, 0.0, 0.009, kNotMeasured};
  report::Raster colours = report::colour_cells(error, {-5.0, 5.0, report::ColorMap::kDiverging});
  CHECK(colours.at(0, 0) == report::Rgba{0, 114, 178, 255});
  CHECK(colours.at(1, 0)[0] >= 248);
  CHECK(colours.at(2, 0) == report::Rgba{213, 94, 0, 255});
  CHECK(colours.at(3, 0)[3] == 0);
}

TEST_CASE("a run that is over has a small picture, which a browser keeps until the run changes") {
  const Served s;
  const std::string target = "/api/runs/" + s.id + "/thumbnail";
  const auto first = WebClient(s.address).get(target);
  REQUIRE(first.status == 200);
  CHECK(first.body.substr(1, 3) == "PNG");
  CHECK_THAT(first.head, Catch::Contains("Content-Type: image/png"));
  const std::size_t tag = first.head.find("ETag: ") + 6;
  const std::string known = "If-None-Match: " + first.head.substr(tag, first.head.find("\r\n", tag) - tag);
  CHECK(WebClient(s.address).request("GET", target, {known}).status == 304);
  std::filesystem::last_write_time(s.folder() / "result.json",
                                   std::filesystem::file_time_type::clock::now() + std::chrono::hours(1));
  CHECK(WebClient(s.address).request("GET", target, {known}).status == 200);
}

TEST_CASE("a run without a map, and one that is being printed, have no small picture") {
  const Served s;
  const std::string target = "/api/runs/" + s.id + "/thumbnail";
  {
    const runs::RunLock lock(s.folder(), runs::RunUse::kPrint);
    CHECK(WebClient(s.address).get(target).status == 204);
  }
  std::filesystem::remove(s.folder() / "log.lcm");
  std::filesystem::remove_all(s.folder() / "nodes");
  std::filesystem::create_directory(s.folder() / "nodes");
  CHECK(WebClient(s.address).get(target).status == 204);
  CHECK(WebClient(s.address).get("/api/runs/none/thumbnail").status == 404);
}

TEST_CASE("a small picture is drawn once, and again when the run has changed") {
  const test::TempFolder folder;
  int drawn = 0;
  page::Thumbnails kept([&](const std::filesystem::path&) { return std::to_string(++drawn); });
  folder.file("run/result.json", "{}");
  CHECK(kept.get(folder.path() / "run") == "1");
  CHECK(kept.get(folder.path() / "run") == "1");
  folder.file("run/result.json", "{ }");
  CHECK(kept.get(folder.path() / "run") == "2");
}

TEST_CASE("small pictures stay within their bound of memory, and the longest unused go first") {
  const test::TempFolder folder;
  std::map<std::string, int> drawn;
  page::Thumbnails kept(
      [&](const std::filesystem::path& run) {
        ++drawn[run.filename()];
        return std::string(3000, 'x');
      },
      10'000);
  const auto get = [&](const std::string& name) { return kept.get(folder.path() / name).size(); };
  for (const char* name : {"a", "b", "a", "c", "d", "a"}) CHECK(get(name) == 3000);
  CHECK(kept.bytes() <= 10'000);
  CHECK(drawn["a"] == 1);
  CHECK(get("b") == 3000);
  CHECK(drawn["b"] == 2);
}
