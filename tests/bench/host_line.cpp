// The line to another computer of a print: rows of a profiler that cross it, the processor time that they
// cost, how long a stop takes that is sent meanwhile, and how well the clock there is known.
//   host_line [--delay MS] [--jitter MS] [--loss SHARE] [--rows N] [--stops N]
#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/hosts/remote_host.h"
#include "print/process/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "runs/folder/run_folder.h"
#include "runtime/run_clock.h"
#include "tests/bench/bench.h"
#include "tests/live/far_hosts.h"

namespace firn::bench::host_line {
namespace {

constexpr std::size_t kRowBytes = 512 * 4 + 100;  // of HEIGHT_PROFILE with 512 points
constexpr std::int64_t kRowNs = 1'000'000;

double processor_s(int pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(in, text);
  std::istringstream words(text.substr(text.rfind(')') + 2));
  std::string skipped;
  for (int n = 0; n < 11; ++n) words >> skipped;
  double user = 0.0, system = 0.0;
  words >> user >> system;
  return (user + system) / double(::sysconf(_SC_CLK_TCK));
}

int pid_of_host(test::FarHosts& hosts) {
  for (const int pid : hosts.pids("bench")) {
    std::error_code gone;
    std::ifstream line("/proc/" + std::to_string(pid) + "/cmdline");
    std::string words;
    std::getline(line, words);
    if (std::filesystem::read_symlink("/proc/" + std::to_string(pid) + "/exe", gone).filename() == "firn" &&
        words.find("--lane") == words.npos)
      return pid;
  }
  return 0;
}

/// A message that carries its number and the moment at which it was sent.
std::vector<std::byte> message(std::int64_t number, std::size_t size) {
  std::vector<std::byte> bytes(size);
  const std::int64_t now = monotonic_ns();
  std::memcpy(bytes.data(), &number, 8);
  std::memcpy(bytes.data() + 8, &now, 8);
  return bytes;
}

double quantile(std::vector<double> x, double q) {
  if (x.empty()) return -1.0;
  std::ranges::sort(x);
  return x[std::min(x.size() - 1, std::size_t(q * double(x.size())))];
}

}  // namespace

FIRN_BENCH(host_line) {
  double delay_ms = 0.0, jitter_ms = 0.0, loss = 0.0;
  int rows = 20'000, stops = 400;
  for (int n = 1; n + 1 < argc; n += 2) {
    const std::string name = argv[n];
    const double value = std::atof(argv[n + 1]);
    if (name == "--delay") delay_ms = value;
    if (name == "--jitter") jitter_ms = value;
    if (name == "--loss") loss = value;
    if (name == "--rows") rows = int(value);
    if (name == "--stops") stops = int(value);
  }
  if (const std::string why = test::FarHosts::refused(); !why.empty())
    return fmt::print(stderr, "{}\n", why), 1;
  test::FarHosts hosts({"bench"});
  hosts.line("bench", delay_ms * 1e-3, jitter_ms * 1e-3, loss);
  const auto root = std::filesystem::temp_directory_path() / fmt::format("firn-line-{}", ::getpid());
  const runs::RunFolder run = runs::RunFolder::create(root, Experiment{}, {}, {"host_line"});
  const BusKey key = BusKey::random();
  ProcessArgs args;
  args.options.run_dir = run.path().string();
  args.options.run_id = run.run_id();
  args.options.epoch_ns = monotonic_ns();
  args.bus_url = default_bus_url(free_bus_port(run.run_id()));
  relay::HostOrder order;
  order.name = order.address = "bench";
  order.program = FIRN_BINARY_DIR "/bin/firn";
  order.run = run.path().filename().string();
  order.run_id = run.run_id();
  order.slack_ms = 1000.0;
  order.silence_s = 5.0;
  order.files = files_for(run, order);
  RemoteHost host(order, FIRN_BINARY_DIR "/bin/relay", args, key.line());
  while (!host.ready() && host.relay().running()) {
    ::usleep(10'000);
    host.service();
  }
  if (!host.ready()) return fmt::print(stderr, "{}\n", host.trouble()), 1;

  // The other computer's bus is another network namespace's: a process of this program sends there.
  const int far = pid_of_host(hosts);
  const std::string order_file = (root / "rows").string();
  LcmBus here(args.bus_url, key);
  here.subscribe("HEIGHT_PROFILE");
  const int relay_pid = int(host.relay().pid());
  const double relay_before = processor_s(relay_pid), far_before = processor_s(far);
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string space = fmt::format("/proc/{}/ns/net", far);
    const int fd = ::open(space.c_str(), O_RDONLY);
    if (fd < 0 || ::setns(fd, CLONE_NEWNET) != 0) ::_exit(1);
    LcmBus there(host.bus_url(), key);
    there.subscribe("SAFE_STOP");
    std::vector<double> ms;
    const auto hear = [&] {
      there.receive([&](std::string_view, std::span<const std::byte> bytes) {
        std::int64_t sent = 0;
        std::memcpy(&sent, bytes.data() + 8, 8);
        ms.push_back(double(monotonic_ns() - sent) * 1e-6);
      });
    };
    const std::int64_t began = monotonic_ns();
    for (int n = 0; n < rows; ++n) {
      there.publish("HEIGHT_PROFILE", message(n, kRowBytes));
      hear();
      const std::int64_t wait = began + (n + 1) * kRowNs - monotonic_ns();
      if (wait > 0) ::usleep(useconds_t(wait / 1000));
    }
    for (int n = 0; n < 500; ++n, ::usleep(1000)) hear();
    std::ofstream(order_file) << ms.size() << " " << quantile(ms, 0.5) << " " << quantile(ms, 0.99) << "\n";
    ::_exit(0);
  }
  std::set<std::int64_t> got;
  const auto hear = [&] {
    here.receive([&](std::string_view, std::span<const std::byte> bytes) {
      std::int64_t number = 0;
      std::memcpy(&number, bytes.data(), 8);
      got.insert(number);
    });
  };
  const std::int64_t began = monotonic_ns();
  const std::int64_t every = rows * kRowNs / std::max(1, stops);
  std::vector<double> bounds_ms;
  for (int n = 0; n < stops;) {
    pollfd p{here.fd(), POLLIN, 0};
    ::poll(&p, 1, 2);
    hear();
    if (monotonic_ns() < began + n * every) continue;
    here.publish("SAFE_STOP", message(n++, 100));
    host.service();
    if (host.clock_bound_ms() > 0.0) bounds_ms.push_back(host.clock_bound_ms());
  }
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    hear();
    ::usleep(2000);
  }
  for (int n = 0; n < 500; ++n, ::usleep(2000)) hear();
  const double took_s = double(monotonic_ns() - began) * 1e-9 - 1.0;
  std::size_t heard = 0;
  double p50 = 0.0, p99 = 0.0;
  std::ifstream(order_file) >> heard >> p50 >> p99;
  fmt::print("line of {} +- {} ms one way, {} of the packets lost\n", delay_ms, jitter_ms, loss);
  fmt::print("HEIGHT_PROFILE of 512 points, 1 kHz: {} of {} rows came\n", got.size(), rows);
  fmt::print("processor time: relay {:.1f} %, firn host {:.1f} % of a core\n",
             100.0 * (processor_s(relay_pid) - relay_before) / took_s,
             100.0 * (processor_s(far) - far_before) / took_s);
  fmt::print("SAFE_STOP to the host meanwhile: p50 {:.1f} ms, p99 {:.1f} ms, {} of {} came\n", p50, p99,
             heard, stops);
  fmt::print("bound of its clock: median {:.2f} ms, largest {:.2f} ms\n", quantile(bounds_ms, 0.5),
             quantile(bounds_ms, 1.0));
  host.relay().kill();
  std::filesystem::remove_all(root);
  return 0;
}

}  // namespace firn::bench::host_line
