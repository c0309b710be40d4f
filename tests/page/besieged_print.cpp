#include "tests/page/besieged_print.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>

#include "files/record/record_file.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runtime/write_ahead.h"
#include "tests/page/web_client.h"
#include "tests/support/tiny_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;

constexpr int kShares = 12;  // of the frames, one a layer

/// Replaces the run's number: it is in every message.
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

std::vector<std::vector<std::byte>> records(const fs::path& file, std::int64_t run_id) {
  const record::MappedFile map(file);
  record::RecordReader reader(map.bytes());
  std::vector<std::vector<std::byte>> all;
  while (const auto r = reader.next()) {
    if (WalKind(r->kind) == WalKind::kHead) continue;
    auto bytes = r->payload;
    if (WalKind(r->kind) == WalKind::kOutputs) bytes = decode_outputs(r->payload).body;
    without_number(all.emplace_back(bytes.begin(), bytes.end()), run_id);
  }
  return all;
}

void print(const runs::RunFolder& run, LabRunOptions o) {
  o.note = [](const std::string&) {};
  if (run_in_lab(full_product(), run, o).result.status != 0)
    throw std::runtime_error("the print did not finish");
}

}  // namespace

PageOf::PageOf(const fs::path& run)
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
}

runs::RunFolder part_to_besiege(const fs::path& root) {
  Experiment e = tiny_print("attacked");
  e.part.shape.height_mm = 0.1;
  return runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
}

void print_alone(const runs::RunFolder& run) { print(run, {}); }

Siege print_besieged(const runs::RunFolder& run, const PageAttack::Size& size) {
  Siege siege;
  auto page = std::make_unique<PageOf>(run.path());
  auto attack = std::make_unique<PageAttack>(page->address, size, 11);
  int layers = 0;
  LabRunOptions o;
  o.progress = [&](const layer_metrics_t&) {
    const std::int64_t wanted =
        std::min<std::int64_t>(size.frames, std::int64_t(++layers) * size.frames / kShares);
    attack->wait(wanted - siege.frames);
    if (layers % 3 != 0) return;
    siege.frames += attack->frames_sent();
    attack.reset();
    page.reset();
    ++siege.killed;
    page = std::make_unique<PageOf>(run.path());
    attack = std::make_unique<PageAttack>(page->address, size, 11 + std::uint64_t(layers));
  };
  print(run, o);
  attack->wait(size.frames - siege.frames);
  siege.frames += attack->frames_sent();
  attack.reset();
  for (int n = 0; n < 100 && !siege.page_serves; ++n) {  // once the besiegers' connections are gone
    ::usleep(100'000);
    siege.page_serves = page->running() && WebClient(page->address).get("/api/runs").status == 200;
  }
  return siege;
}

std::vector<std::string> differing_files(const runs::RunFolder& a, const runs::RunFolder& b) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(a.path() / "nodes")) {
    if (entry.path().extension() != ".wal") continue;
    const auto one = records(entry.path(), a.run_id());
    const auto other = records(b.path() / "nodes" / entry.path().filename(), b.run_id());
    if (one.size() < 10 || one != other) names.push_back(entry.path().filename().string());
  }
  return names;
}

}  // namespace firn::test
