// Measures the way from HEIGHT_MAP to LAYER_PLAN, as the scheduler sees both, in live prints without a page
// and in live prints whose page is besieged, alternating; wall time.
//   ./firn bench page_attack [PAIRS] [CONNECTIONS] [FRAMES]
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
#include "tests/page/page_attack.h"

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

}  // namespace

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 30;
  const test::PageAttack::Size size{argc > 2 ? std::atoi(argv[2]) : 1'000,
                                    argc > 3 ? std::atoi(argv[3]) : 100'000, 16};
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
      "prints "
      "failed; load %.1f\n",
      alone.size(), attacked.size(), at(alone, 0.5), at(alone, 0.99), at(attacked, 0.5), at(attacked, 0.99),
      failed, load[0]);
  return failed == 0 && at(attacked, 0.99) <= 1.1 * at(alone, 0.99) ? 0 : 1;
}
