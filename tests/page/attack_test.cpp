// A print that a page watches is the print that nobody watches, whatever happens to the page.
#include <catch2/catch.hpp>

#include <unistd.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "files/record/record_file.h"
#include "print/labs/print_labs.h"
#include "print/live/child_process.h"
#include "print/simulated/lab_run.h"
#include "runtime/write_ahead.h"
#include "tests/page/page_attack.h"
#include "tests/page/web_client.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

using namespace firn;
namespace fs = std::filesystem;

namespace {

class PageOf {
 public:
  explicit PageOf(const fs::path& run)
      : process_("page", FIRN_BINARY_DIR "/bin/page",
                 {"--run", run.string(), "--control-fd", std::to_string(ChildProcess::kControlFd)},
                 run.parent_path() / "page.err") {
    process_.control().say("TOKEN secret");
    for (int n = 0; n < 1000 && address.empty(); ++n) {
      if (const auto line = process_.control().next(); line && line->starts_with("PAGE "))
        address = line->substr(5);
      else
        ::usleep(10'000);
    }
    REQUIRE(!address.empty());
  }
  ~PageOf() { process_.kill(); }
  bool running() { return process_.running(); }
  std::string address;

 private:
  ChildProcess process_;
};

Experiment part() {
  Experiment e = test::tiny_print("attacked");
  e.part.shape.height_mm = 0.1;
  return e;
}

RunFolder created(const fs::path& root) {
  return RunFolder::create(root, part(), make_inputs(part(), ""), {"test"});
}

/// Replaces the run's number, the time at which its folder was made: it is in every message.
void without_number(std::vector<std::byte>& bytes, std::int64_t run_id) {
  for (const bool big : {true, false}) {
    std::array<std::byte, 8> number;
    for (std::size_t k = 0; k < 8; ++k) number[k] = std::byte(run_id >> 8 * (big ? 7 - k : k) & 0xff);
    for (auto at = bytes.begin(); at != bytes.end();) {
      at = std::search(at, bytes.end(), number.begin(), number.end());
      if (at != bytes.end()) at = std::fill_n(at, 8, std::byte(0));
    }
  }
}

/// The part of a write-ahead file that replay compares: events, and outputs without the handler's wall time.
std::vector<std::vector<std::byte>> records(const fs::path& file, std::int64_t run_id) {
  const logfile::MappedFile map(file);
  logfile::RecordReader reader(map.bytes());
  std::vector<std::vector<std::byte>> all;
  while (const auto r = reader.next()) {
    if (WalKind(r->kind) == WalKind::kHead) continue;
    auto bytes = r->payload;
    if (WalKind(r->kind) == WalKind::kOutputs) bytes = decode_outputs(r->payload).body;
    without_number(all.emplace_back(bytes.begin(), bytes.end()), run_id);
  }
  return all;
}

void check_same_bytes(const RunFolder& a, const RunFolder& b) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(a.path() / "nodes")) {
    if (entry.path().extension() != ".wal") continue;
    INFO(entry.path().filename().string());
    const auto one = records(entry.path(), a.run_id());
    const auto other = records(b.path() / "nodes" / entry.path().filename(), b.run_id());
    CHECK(one.size() > 10);
    CHECK(one == other);
    ++files;
  }
  CHECK(files > 5);
}

}  // namespace

TEST_CASE(
    "a print whose page is besieged, killed and begun anew writes the bytes of one that nobody watches") {
  const test::TempFolder place;
  const RunFolder alone = created(place.path() / "alone"), watched = created(place.path() / "watched");
  LabRunOptions o;
  o.note = [](const std::string&) {};
  REQUIRE(run_in_lab(alone, o).result.status == 0);
  auto page = std::make_unique<PageOf>(watched.path());
  auto attack = std::make_unique<test::PageAttack>(page->address, test::PageAttack::Size{}, 11);
  int layers = 0, killed = 0;
  o.progress = [&](const layer_metrics_t&) {
    if (++layers % 3 != 0) return;
    attack.reset();
    page.reset();  // kill -9
    ++killed;
    page = std::make_unique<PageOf>(watched.path());
    attack = std::make_unique<test::PageAttack>(page->address, test::PageAttack::Size{50, 500, 4}, 12);
  };
  REQUIRE(run_in_lab(watched, o).result.status == 0);
  attack->wait();
  CHECK(page->running());
  CHECK(killed > 2);
  CHECK(test::WebClient(page->address).get("/api/runs").status == 200);
  check_same_bytes(alone, watched);
}
