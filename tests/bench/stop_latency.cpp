// Measures the time from `firn ctl RUN stop` to SAFE_STOP on live prints: percentiles over N prints, wall
// time.
//   ./firn bench stop_latency [N]
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "tests/live/live_run.h"

namespace {

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  char chunk[512];
  while (pipe && std::fgets(chunk, sizeof chunk, pipe)) text += chunk;
  if (pipe) ::pclose(pipe);
  return text;
}

double percentile(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, std::size_t(share * double(sorted.size())))];
}

}  // namespace

int main(int argc, char** argv) {
  using namespace firn;
  const int prints = argc > 1 ? std::max(1, std::atoi(argv[1])) : 100;
  RandomStream random(1, Purpose::kTest);
  std::vector<double> ms;
  int lost = 0;
  for (int n = 0; n < prints; ++n) {
    test::LiveRun run(test::tiny_part(std::uint64_t(n)));
    run.start(false);
    if (!run.wait_started()) continue;
    ::usleep(100'000 + random.below(1'200'000));
    const std::string said =
        output_of(FIRN_BINARY_DIR "/bin/firn ctl --json " + run.path().string() + " stop 2>&1");
    const auto answer = nlohmann::json::parse(said, nullptr, false);
    if (answer.is_object() && answer.value("ok", false))
      ms.push_back(answer.value("ms", 0.0));
    else
      ++lost;  // the print had ended
    run.wait();
    run.wait_all_gone();
  }
  if (ms.empty()) return 1;
  std::sort(ms.begin(), ms.end());
  double load[3] = {};
  ::getloadavg(load, 3);
  std::printf(
      "%zu stops (%d prints were over): p50 %.2f ms, p90 %.2f ms, p99 %.2f ms, most %.2f ms; load %.1f\n",
      ms.size(), lost, percentile(ms, 0.5), percentile(ms, 0.9), percentile(ms, 0.99), ms.back(), load[0]);
  return percentile(ms, 0.99) <= 20.0 ? 0 : 1;
}
