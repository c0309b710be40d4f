// Measures the cost of an attack on the page to a print. First in one process: which write-ahead files
// differ, but for times, from those of a print that nobody watches, when the page is besieged and killed
// (kill -9) after every third layer. Then live, alternating: the way from HEIGHT_MAP to LAYER_PLAN, as the
// scheduler sees both, without a page and with one that is besieged; wall time. The interval is of prints
// drawn anew.
//   ./firn bench page_attack [PAIRS] [CONNECTIONS] [FRAMES]
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "files/record/record_file.h"
#include "lcmtypes/channels.h"
#include "runtime/write_ahead.h"
#include "tests/bench/bench.h"
#include "tests/live/live_run.h"
#include "tests/page/besieged_print.h"
#include "tests/support/temp_folder.h"

namespace firn::bench::page_attack {

namespace {

using namespace firn;

// From the scheduler's events: their times are of the node clock.
void add_ms(const std::filesystem::path& wal, double time_scale, std::vector<double>& ms) {
  const record::MappedFile file(wal);
  record::RecordReader reader(file.bytes());
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

constexpr double kHeight_mm = 0.4;  // about 110 layers: a hundredth of them is more than one
constexpr int kDraws = 2'000;

double at(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0
                        : values[std::min(values.size() - 1, std::size_t(share * double(values.size())))];
}

/// Times of each print [ms].
using Prints = std::vector<std::vector<double>>;

std::vector<double> pooled(const Prints& prints) {
  std::vector<double> all;
  for (const auto& ms : prints) all.insert(all.end(), ms.begin(), ms.end());
  return all;
}

void print_once(std::uint64_t seed, const test::PageAttack::Size* size, Prints& prints, int& failed) {
  Experiment e = test::tiny_part(seed);
  e.part.shape.height_mm = kHeight_mm;
  test::LiveRun run(e);
  if (size) run.page_token = "secret";
  run.start(false);
  if (!run.wait_started()) return;
  std::unique_ptr<test::PageAttack> attack;
  if (size) attack = std::make_unique<test::PageAttack>(run.page_address(), *size, seed);
  if (run.wait() != 0) ++failed;
  attack.reset();
  run.wait_all_gone();
  add_ms(run.folder().wal_path("scheduler"), e.run.time_scale, prints.emplace_back());
}

/// Prints the ratio of a percentile, besieged to alone, with its 95 % interval. @returns the ratio
double tell_ratio(double share, const Prints& alone, const Prints& attacked) {
  const auto ratio = [&](const Prints& a, const Prints& b) {
    return at(pooled(b), share) / at(pooled(a), share);
  };
  RandomStream random(1, Purpose::kTest);
  const auto drawn = [&](const Prints& prints) {
    Prints some;
    for (std::size_t n = 0; n < prints.size(); ++n) some.push_back(prints[random.below(prints.size())]);
    return some;
  };
  std::vector<double> ratios;
  for (int n = 0; n < kDraws; ++n) ratios.push_back(ratio(drawn(alone), drawn(attacked)));
  std::printf("p%.0f: alone %.2f ms, besieged %.2f ms, ratio %.3f [%.3f, %.3f]\n", share * 100.0,
              at(pooled(alone), share), at(pooled(attacked), share), ratio(alone, attacked),
              at(ratios, 0.025), at(ratios, 0.975));
  return ratio(alone, attacked);
}

bool same_bytes(const test::PageAttack::Size& size) {
  const test::TempFolder place;
  const runs::RunFolder alone = test::part_to_besiege(place.path() / "alone"),
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

FIRN_BENCH(page_attack) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 6;
  const test::PageAttack::Size size{argc > 2 ? std::atoi(argv[2]) : 1'000,
                                    argc > 3 ? std::atoi(argv[3]) : 100'000, 16};
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
  const bool same = same_bytes(size);
  Prints alone, attacked;
  int failed = 0;
  for (int n = 0; n < pairs; ++n)
    for (const bool attack : {n % 2 == 1, n % 2 == 0})
      print_once(std::uint64_t(n), attack ? &size : nullptr, attack ? attacked : alone, failed);
  double load[3] = {};
  ::getloadavg(load, 3);
  std::printf("map to plan, %zu and %zu layers of %d pairs; %d prints failed; load %.1f\n",
              pooled(alone).size(), pooled(attacked).size(), pairs, failed, load[0]);
  if (alone.empty() || attacked.empty()) return 1;
  for (const double share : {0.5, 0.9}) tell_ratio(share, alone, attacked);
  return tell_ratio(0.99, alone, attacked) <= 1.1 && same && failed == 0 ? 0 : 1;
}

}  // namespace firn::bench::page_attack
