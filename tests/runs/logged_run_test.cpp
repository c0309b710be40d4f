// A run that is over is read from its log, and looks as from its write-ahead files.
#include <catch2/catch.hpp>

#include <fstream>

#include "files/json.h"
#include "files/text_file.h"
#include "firn/height_map_t.hpp"
#include "page/map_head.h"
#include "page/run_maps.h"
#include "page/run_view.h"
#include "page/watched_run.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/pack.h"
#include "runs/read/run_reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

using namespace firn;
using namespace firn::page;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

std::set<std::string, std::less<>> shown_channels() {
  auto channels = RunView::channels();
  channels.merge(RunMaps::channels());
  channels.erase("HEIGHT_PROFILE");
  return channels;
}

bool reads_log(const fs::path& run) {
  return runs::RunReader(run, shown_channels(), runs::RunReader::Source::kLog).reads_log();
}

fs::path over(const fs::path& root) {
  const Experiment e = test::tiny_print("page");
  const runs::RunFolder run = runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  o.note = [](const std::string&) {};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  return run.path();
}

/// A copy in a folder of the same name.
fs::path copied(const fs::path& run, const fs::path& to) {
  fs::create_directories(to);
  fs::copy(run, to / run.filename(), fs::copy_options::recursive);
  return to / run.filename();
}

/// Without the parts that only one of the two holds: bytes of a port are in no log, and of a print in one
/// process no file holds the words of the launcher.
json greeting(const WatchedRun& run) {
  json hello = json::parse(run.hello(0.0, "run", false, {})), events = json::array();
  for (json& instrument : hello["instruments"]) instrument.erase("last");
  for (json& event : hello["events"]) {
    event.erase("n");
    if (event["words"] != "the print begins") events.push_back(event);
  }
  hello["events"] = events;
  hello["run"].erase("id");  // has the folder's place
  return hello;
}

void flip(const fs::path& file, std::size_t at) {
  std::fstream f(file, std::ios::binary | std::ios::in | std::ios::out);
  f.seekg(std::streamoff(at));
  const char byte = char(f.get() ^ 0x10);
  f.seekp(std::streamoff(at));
  f.put(byte);
}

}  // namespace

TEST_CASE("a run that is over has the rows and the maps of its write-ahead files in its log, packed or not") {
  const test::TempFolder place;
  const fs::path run = over(place.path() / "a"), files = copied(run, place.path() / "files"),
                 packed = copied(run, place.path() / "packed");
  fs::remove(files / "log.lcm.idx");
  runs::pack_run(packed);
  CHECK_FALSE(reads_log(files));
  WatchedRun of_files(full_product(), files, 0.0);
  for (const fs::path& folder : {run, packed}) {
    REQUIRE(reads_log(folder));
    WatchedRun of_log(full_product(), folder, 0.0);
    CHECK(greeting(of_log) == greeting(of_files));
    REQUIRE(of_log.newest_layer() == of_files.newest_layer());
    for (int layer = 0; layer <= *of_files.newest_layer(); ++layer)
      for (int s = 0; s < int(std::size(kSurfaceWords)); ++s)
        CHECK(of_log.map({Surface(s), layer}) == of_files.map({Surface(s), layer}));
  }
}

TEST_CASE("a log that is damaged, cut or without its index is not read in place of the files") {
  const test::TempFolder place;
  const fs::path run = over(place.path() / "a");
  const std::string log = read_file(run / "log.lcm");
  const auto trusted = [&](const char* name, const auto& harm) {
    const fs::path harmed = copied(run, place.path() / name);
    harm(harmed);
    return reads_log(harmed);
  };
  CHECK(trusted("whole", [](const fs::path&) {}));
  CHECK_FALSE(trusted("no index", [](const fs::path& f) { fs::remove(f / "log.lcm.idx"); }));
  CHECK_FALSE(
      trusted("a bit", [&](const fs::path& f) { flip(f / "log.lcm", log.find("HEIGHT_MAP") + 300); }));
  CHECK_FALSE(trusted("cut", [&](const fs::path& f) { fs::resize_file(f / "log.lcm", log.size() - 1); }));
  CHECK_FALSE(trusted("cut index", [](const fs::path& f) {
    fs::resize_file(f / "log.lcm.idx", fs::file_size(f / "log.lcm.idx") / 2);
  }));
  CHECK_FALSE(trusted("a hole in the index", [](const fs::path& f) {
    flip(f / "log.lcm.idx", fs::file_size(f / "log.lcm.idx") / 2);
  }));
}

TEST_CASE("a run that was stopped in the middle of nowhere is read from its files") {
  const test::TempFolder place;
  const Experiment e = test::tiny_print("page");
  const runs::RunFolder run =
      runs::RunFolder::create(place.path(), e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  o.note = [](const std::string&) {};
  o.crash_after_steps = 3000;
  run_in_lab(full_product(), run, o);
  CHECK_FALSE(reads_log(run.path()));
  CHECK(WatchedRun(full_product(), run.path(), 0.0).newest_layer());
}

TEST_CASE("the front of a height map is what its whole message says, and no other message has one") {
  height_map_t m{};
  m.header.utime_us = 123'456'789;
  m.layer = 7;
  m.grid = {3, 2, 0.25, 0.5, -1.0, 4.0};
  m.n = 6;
  m.height_mm.assign(6, 0.5f);
  m.quality.assign(6, 0);
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  const auto head = map_head(bytes);
  REQUIRE(head);
  CHECK(head->utime_us == 123'456'789);
  CHECK(head->layer == 7);
  CHECK(head->grid.nx == 3);
  CHECK(head->grid.origin_y_mm == 4.0);
  const std::size_t front = bytes.size() - 6 * 5 - 3 * 8;  // without cells, noise, share and rows
  for (std::size_t n = 0; n < bytes.size(); ++n)
    CHECK(map_head(std::span(bytes).first(n)).has_value() == (n >= front));
  bytes[0] ^= std::byte(1);
  CHECK_FALSE(map_head(bytes));
}
