// Measures the cost of an attack on the page to a print. First in one process: which write-ahead files
// differ, but for times, from those of a print that nobody watches, when the page is besieged and killed
// (kill -9) after every third layer. Then live, alternating: the way from HEIGHT_MAP to LAYER_PLAN, as the
// scheduler sees both, without a page and with one that is besieged; wall time.
//   ./firn bench page_attack [PAIRS] [CONNECTIONS] [FRAMES]
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "files/record/record_file.h"
#include "lcmtypes/channels.h"
#include "runtime/write_ahead.h"
#include "tests/live/live_run.h"
#include "tests/page/besieged_print.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace firn;

// From the scheduler's events: their times are of the node clock.
void add_ms(const std::filesystem::path& wal, double time_scale, std::vector<double>& ms) {
  const logfile::MappedFile file(wal);
  logfile::RecordReader reader(file.bytes());
  std::int64_t map_us = -1;
  while (const auto r = reader.next()) {
    if (WalKind(r->kind) != WalKind::kEvent) continue;
    const Event e = decode_event(r->payload).event;
    if (e.kind != EventKind::kMessage) continue;
    if (e.channel == channels::kHeightMap.name) map_us = e.now.us;
    if (e.channel != channels::kLayerPlan.name || map_us < 0) continue;
    ms.push_back(double(e.now.us - map_us) * 1e-3 / time_scale);
    map_us = -1;
  }
}

double at(std::vector<double>& values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0
                        : values[std::min(values.size() - 1, std::size_t(share * double(values.size())))];
}

void print_once(std::uint64_t seed, const test::PageAttack::Size* size, std::vector<double>& ms,
                int& failed) {
  const Experiment e = test::tiny_part(seed);
  test::LiveRun run(e);
  if (size) run.page_token = "secret";
  run.start(false);
  if (!run.wait_started()) return;
  std::unique_ptr<test::PageAttack> attack;
  if (size) attack = std::make_unique<test::PageAttack>(run.page_address(), *size, seed);
  if (run.wait() != 0) ++failed;
  attack.reset();
  run.wait_all_gone();
  add_ms(run.folder().wal_path("scheduler"), e.run.time_scale, ms);
}

bool same_bytes(const test::PageAttack::Size& size) {
  const test::TempFolder place;
  const RunFolder alone = test::part_to_besiege(place.path() / "alone"),
                  watched = test::part_to_besiege(place.path() / "watched");
  test::print_alone(alone);
  const test::Siege siege = test::print_besieged(watched, size);
  const auto differing = test::differing_files(alone, watched);
  std::printf("%d connections, %lld random frames, %d tabs that never read, page killed %d times, %s: ",
              size.connections, static_cast<long long>(siege.frames), size.deaf, siege.killed,
              siege.page_serves ? "serves afterwards" : "does NOT serve afterwards");
  if (differing.empty()) std::printf("every write-ahead file has the same bytes\n");
  for (const std::string& name : differing) std::printf("%s DIFFERS\n", name.c_str());
  std::fflush(stdout);
  return differing.empty() && siege.page_serves;
}

}  // namespace

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 30;
  const test::PageAttack::Size size{argc > 2 ? std::atoi(argv[2]) : 1'000,
                                    argc > 3 ? std::atoi(argv[3]) : 100'000, 16};
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
  const bool same = same_bytes(size);
  std::vector<double> alone, attacked;
  int failed = 0;
  for (int n = 0; n < pairs; ++n) {
    print_once(std::uint64_t(n), nullptr, alone, failed);
    print_once(std::uint64_t(n), &size, attacked, failed);
  }
  double load[3] = {};
  ::getloadavg(load, 3);
  std::printf(
      "map to plan, %zu and %zu layers: alone p50 %.2f, p99 %.2f ms; besieged p50 %.2f, p99 %.2f ms; %d "
      "prints failed; load %.1f\n",
      alone.size(), attacked.size(), at(alone, 0.5), at(alone, 0.99), at(attacked, 0.5), at(attacked, 0.99),
      failed, load[0]);
  return same && failed == 0 && at(attacked, 0.99) <= 1.1 * at(alone, 0.99) ? 0 : 1;
}
