// Measures the time from `firn ctl RUN stop`, or from the page's command, to the answer that SAFE_STOP is on
// the bus: percentiles over N live prints, wall time.
//   ./firn bench stop_latency [N] [page]
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "files/json.h"
#include "tests/bench/bench.h"
#include "tests/live/live_run.h"
#include "tests/page/web_client.h"

namespace firn::bench::stop_latency {

namespace {

constexpr int kTabs = 8;  // that watch beside the one that stops

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  char chunk[512];
  while (pipe && std::fgets(chunk, sizeof chunk, pipe)) text += chunk;
  if (pipe) ::pclose(pipe);
  return text;
}

// Returns the time of a stop by the page, over the line that a browser keeps for commands, while other tabs
// follow the maps; 0: the print had ended.
double page_stop_ms(firn::test::LiveRun& run) {
  std::vector<std::unique_ptr<firn::test::WebClient>> tabs;
  for (int n = 0; n < kTabs; ++n) {
    auto& tab = *tabs.emplace_back(std::make_unique<firn::test::WebClient>(run.page_address()));
    if (tab.open("/ws") == 101) tab.send(R"({"type":"follow","surface":"measured"})");
  }
  firn::test::WebClient line(run.page_address());
  if (line.open("/command?run=live", {"Sec-WebSocket-Protocol: firn, secret"}) != 101) return 0.0;
  const auto began = std::chrono::steady_clock::now();
  line.send(R"({"type":"command","id":1,"command":"safe_stop"})");
  const std::string answer = line.next_of("answer", 10.0).value_or("");
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
  return answer.find("\"ok\":true") == std::string::npos ? 0.0 : ms;
}

double percentile(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, std::size_t(share * double(sorted.size())))];
}

}  // namespace

FIRN_BENCH(stop_latency) {
  using namespace firn;
  const int prints = argc > 1 ? std::max(1, std::atoi(argv[1])) : 100;
  const bool page = argc > 2 && std::string(argv[2]) == "page";
  RandomStream random(1, Purpose::kTest);
  std::vector<double> ms;
  int lost = 0;
  for (int n = 0; n < prints; ++n) {
    test::LiveRun run(test::tiny_part(std::uint64_t(n)));
    if (page) run.page_token = "secret";
    run.start(false);
    if (!run.wait_started()) continue;
    ::usleep(100'000 + random.below(1'200'000));
    if (page) {
      if (const double took_ms = page_stop_ms(run); took_ms > 0.0)
        ms.push_back(took_ms);
      else
        ++lost;
      run.wait();
      run.wait_all_gone();
      continue;
    }
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

}  // namespace firn::bench::stop_latency
