// Measures the merge of a study's shards, whose prints are imagined: build/bench/study_merge [PRINTS
// [SHARDS]] Seconds and peak memory of: writing the shards, --status, the merge with its results and page.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "cli/compare_command.h"
#include "core/grid/random.h"
#include "core/options/number.h"
#include "studies/compare/study_lab.h"
#include "tests/bench/bench.h"
#include "tests/support/temp_folder.h"

namespace firn::bench::study_merge {

namespace {

StudyPrint imagined(const Experiment& e, const Blobs&, bool) {
  StudyPrint p{true, "finished", "imagined", {}, 0.2};
  RandomStream random(e.plant.seed, Purpose::kTest, std::uint32_t(1000.0 * e.control.smf.kp));
  for (std::size_t m = 0; m < inkjet_study_lab().metrics.size(); ++m)
    p.metrics.push_back(1.0 + 0.1 * e.control.smf.kp + 0.1 * random.normal());
  p.within = true;
  return p;
}

double processor_s(const rusage& of) {
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(of.ru_utime) + seconds(of.ru_stime);
}

template <class F>
void time(const char* name, F&& f) {
  rusage before, after;
  getrusage(RUSAGE_SELF, &before);
  const auto began = std::chrono::steady_clock::now();
  const int code = f();
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  getrusage(RUSAGE_SELF, &after);
  std::printf("%-28s %7.2f s, %7.2f s of processor time  peak %5ld MB  exit code %d\n", name, s,
              processor_s(after) - processor_s(before), after.ru_maxrss / 1024, code);
}

}  // namespace

FIRN_BENCH(study_merge) {
  const int prints = argc > 1 ? whole_number<int>(argv[1], 4, 1'000'000).value_or(0) : 100'000,
            shards = argc > 2 ? whole_number<int>(argv[2], 1, 10'000).value_or(0) : 40;
  if (prints == 0 || shards == 0) {
    std::fprintf(stderr, "study_merge [PRINTS in [4, 1000000] [SHARDS in [1, 10000]]]\n");
    return 2;
  }
  StudyLab lab = inkjet_study_lab();
  lab.print = &imagined;
  const test::TempFolder folder;
  CompareOptions options;
  options.study =
      folder
          .file("study.toml", "seeds = " + std::to_string(prints / 2) +
                                  "\nset = [\"control.scheme=smf\"]\n[vary]\n\"control.smf.kp\" = [1, 2]\n")
          .string();
  options.output = (folder.path() / "out").string();
  options.threads = 1;
  time("shards", [&] {
    for (int k = 1; k <= shards; ++k) {
      CompareOptions one = options;
      one.shard = std::to_string(k) + "/" + std::to_string(shards);
      if (const int code = compare(one, lab, nullptr); code != 0) return code;
    }
    return 0;
  });
  CompareOptions status = options;
  status.status = true;
  time("--status", [&] { return compare(status, lab, nullptr); });
  time("merge", [&] { return compare(options, lab, nullptr); });
  return 0;
}

}  // namespace firn::bench::study_merge
