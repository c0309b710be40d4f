// Measures the process of the page under load: processor time with tabs that follow maps of 256 x 256 at 10
// Hz, the delay of a map from its record to the tabs, beside a tab that never reads, and the memory over many
// messages.
//   ./firn bench page_load [--tabs 16] [--seconds 20] [--messages 100000]
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "files/record/record_file.h"
#include "firn/device_state_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/height_profile_t.hpp"
#include "lcmtypes/convert.h"
#include "page/server.h"
#include "print/labs/full_product.h"
#include "runs/folder/run_folder.h"
#include "runtime/run_clock.h"
#include "runtime/write_ahead.h"
#include "tests/bench/bench.h"
#include "tests/page/web_client.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn::bench::page_load {

namespace {

using namespace firn;
using test::WebClient;

constexpr int kCells = 256;
constexpr std::int64_t kPause_us = 100'000;

double now_s() { return double(monotonic_us()) * 1e-6; }

Experiment experiment() {
  Experiment e = test::tiny_print("page-load");
  e.grid = {kCells, kCells, 0.05, 0.05, 0.0, 0.0};
  e.part.shape.width_mm = 10.0;
  e.part.shape.depth_mm = 10.0;
  return e;
}

/// Writes the records of a print that does nothing else.
class FalsePrint {
 public:
  explicit FalsePrint(const std::filesystem::path& root)
      : folder(runs::RunFolder::create(root, experiment(), make_inputs(full_product(), experiment(), {}),
                                       {"page_load"})),
        mapper_(NodeId::kSurfaceMapper, folder.run_id()),
        profiler_(NodeId::kLaserProfiler, folder.run_id()),
        stage_(NodeId::kStage, folder.run_id()),
        mapper_wal_(folder.wal_path("surface_mapper"), record::RecordWriter::Mode::kCreate),
        profiler_wal_(folder.wal_path("laser_profiler"), record::RecordWriter::Mode::kCreate),
        stage_wal_(folder.wal_path("stage"), record::RecordWriter::Mode::kCreate) {
    std::filesystem::create_directories(folder.path() / "io");
    lock_ = ::open((folder.path() / "io" / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    ::flock(lock_, LOCK_EX);
  }
  ~FalsePrint() { ::close(lock_); }

  void map(int layer) {
    height_map_t m{};
    m.layer = layer;
    m.map_id = layer;
    HeightMap height(experiment().grid);
    for (int j = 0; j < kCells; ++j)
      for (int i = 0; i < kCells; ++i)
        height.at(i, j) = 0.004 * layer + 0.001 * std::sin(0.1 * i) * std::cos(0.07 * j + layer);
    set_height(m, height);
    m.quality.assign(m.height_mm.size(), 0);
    write(mapper_, mapper_wal_, channels::kHeightMap, m);
  }
  void row(int layer, int n) {
    height_profile_t m{};
    m.layer = layer;
    m.scan_id = layer;
    m.row = n;
    m.rows = kCells;
    m.dx_mm = 0.05;
    m.y_mm = 0.05 * n;
    m.n = kCells;
    for (int i = 0; i < kCells; ++i) m.z_mm.push_back(float(0.004 * layer + 0.001 * std::sin(0.1 * i + n)));
    write(profiler_, profiler_wal_, channels::kHeightProfile, m);
  }
  void word(int n) {
    device_state_t m{};
    m.node = "stage";
    m.state = 4;
    m.text = "word " + std::to_string(n);
    write(stage_, stage_wal_, channels::device_state(NodeId::kStage), m);
  }

  runs::RunFolder folder;

 private:
  template <class Message>
  void write(Outbox& outbox, record::RecordWriter& wal, const Channel<Message>& channel, const Message& m) {
    outbox.begin(Time{monotonic_us()}, 0);
    outbox.send(channel, m);
    bytes_.clear();
    encode_outputs(++step_, 0, outbox, bytes_);
    wal.append(std::uint16_t(WalKind::kOutputs), bytes_);
  }

  Outbox mapper_, profiler_, stage_;
  record::RecordWriter mapper_wal_, profiler_wal_, stage_wal_;
  std::vector<std::byte> bytes_;
  std::uint64_t step_ = 0;
  int lock_ = -1;
};

/// The page in a process of its own.
class PageProcess {
 public:
  explicit PageProcess(const std::filesystem::path& run) {
    int said[2];
    if (::pipe(said) != 0) throw std::runtime_error("no pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      ::close(said[0]);
      ::signal(SIGPIPE, SIG_IGN);
      page::ServerOptions options;
      options.live = run;
      options.places = {run.parent_path()};
      options.listening = [&](const std::string& at) {
        if (::write(said[1], (at + "\n").data(), at.size() + 1) < 0) ::_exit(1);
        ::close(said[1]);
      };
      page::serve(full_product(), options);
      ::_exit(0);
    }
    ::close(said[1]);
    for (char c; ::read(said[0], &c, 1) == 1 && c != '\n';) address += c;
    ::close(said[0]);
  }
  ~PageProcess() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  double cpu_s() const {
    clockid_t clock{};
    timespec t{};
    ::clock_getcpuclockid(pid_, &clock);
    ::clock_gettime(clock, &t);
    return double(t.tv_sec) + double(t.tv_nsec) * 1e-9;
  }
  double memory_MB() const {
    std::ifstream in("/proc/" + std::to_string(pid_) + "/status");
    for (std::string word; in >> word;)
      if (word == "RssAnon:") {
        double kB = 0.0;
        in >> kB;
        return kB / 1024.0;
      }
    return 0.0;
  }
  std::string address;

 private:
  pid_t pid_ = -1;
};

/// Tabs that take every map, and note the age of each by the clock.
class Tabs {
 public:
  Tabs(const std::string& address, int count) {
    for (int n = 0; n < count; ++n) {
      auto& tab = *tabs_.emplace_back(std::make_unique<WebClient>(address));
      if (tab.open("/ws") != 101 || !tab.next_of("hello", 10.0)) throw std::runtime_error("a tab is refused");
      tab.send(R"({"type":"follow","surface":"measured"})");
    }
    delays_.resize(tabs_.size());
    for (std::size_t n = 0; n < tabs_.size(); ++n) threads_.emplace_back([this, n] { read(n); });
  }
  ~Tabs() {
    stop_ = true;
    for (std::thread& t : threads_) t.join();
  }
  /// Ends the reading. @returns the delays [ms], sorted
  std::vector<double> delays_ms() {
    stop_ = true;
    for (std::thread& t : threads_) t.join();
    threads_.clear();
    std::vector<double> all;
    for (const auto& some : delays_) all.insert(all.end(), some.begin(), some.end());
    std::sort(all.begin(), all.end());
    return all;
  }
  std::size_t bytes() const { return bytes_; }

 private:
  void read(std::size_t n) {
    bool greeted = false;  // by a map of before
    while (!stop_) {
      const auto frame = tabs_[n]->next(0.2);
      if (!frame) continue;
      bytes_ += frame->payload.size();
      if (frame->opcode != 2 || frame->payload.size() < 32) continue;
      if (!std::exchange(greeted, true)) continue;
      double t_s = 0.0;
      std::memcpy(&t_s, frame->payload.data() + 24, sizeof t_s);
      delays_[n].push_back((now_s() - t_s) * 1e3);
    }
  }

  std::vector<std::unique_ptr<WebClient>> tabs_;
  std::vector<std::vector<double>> delays_;
  std::vector<std::thread> threads_;
  std::atomic<bool> stop_ = false;
  std::atomic<std::size_t> bytes_ = 0;
};

double at(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return std::nan("");
  return sorted[std::min(sorted.size() - 1, std::size_t(share * double(sorted.size())))];
}

enum class Kind { kMaps, kRows };

// Ten maps a second; or the rows of a map a second, a tenth of them at a time.
double load(FalsePrint& print, const PageProcess& page, int count, double seconds, Kind kind, bool deaf,
            int& layer) {
  Tabs tabs(page.address, count);
  std::unique_ptr<WebClient> never_reads;
  if (deaf) {
    never_reads = std::make_unique<WebClient>(page.address);
    if (never_reads->open("/ws") == 101) never_reads->send(R"({"type":"follow","surface":"measured"})");
  }
  const double began_s = now_s(), cpu_s = page.cpu_s();
  int row = 0;
  for (std::int64_t next = monotonic_us(); now_s() < began_s + seconds; next += kPause_us) {
    if (kind == Kind::kMaps) {
      print.map(++layer);
    } else {
      for (int n = 0; n < kCells / 10; ++n) print.row(layer + 1, row++ % kCells);
    }
    ::usleep(useconds_t(std::max<std::int64_t>(0, next + kPause_us - monotonic_us())));
  }
  const double wall_s = now_s() - began_s, percent = 100.0 * (page.cpu_s() - cpu_s) / wall_s;
  const std::vector<double> ms = tabs.delays_ms();
  double machine[3] = {};
  ::getloadavg(machine, 3);
  std::printf(
      "%s to %d tabs%s: %.2f %% of a core; %.1f maps/s a tab, %.0f kB each; delay p50 %.0f, p99 %.0f, "
      "most %.0f ms; load %.1f\n",
      kind == Kind::kMaps ? "256 x 256 at 10 Hz" : "the rows of 256 x 256 in a second", count,
      deaf ? " beside one that never reads" : "", percent, double(ms.size()) / wall_s / count,
      ms.empty() ? 0.0 : double(tabs.bytes()) / double(ms.size()) / 1e3, at(ms, 0.5), at(ms, 0.99),
      at(ms, 1.0), machine[0]);
  std::fflush(stdout);
  return percent;
}

// Some tabs read, one never does.
double memory(FalsePrint& print, const PageProcess& page, int messages) {
  Tabs tabs(page.address, 3);
  WebClient deaf(page.address);
  if (deaf.open("/ws") == 101) deaf.send(R"({"type":"follow","surface":"measured"})");
  const auto say = [&](int count) {
    for (int n = 0; n < count; ++n) {
      print.word(n);
      if (n % 500 == 499) ::usleep(50'000);
    }
    ::usleep(500'000);
  };
  say(messages / 10);
  const double before_MB = page.memory_MB();
  say(messages);
  const double after_MB = page.memory_MB();
  std::printf("%d messages: %.1f MB of memory before, %.1f after\n", messages, before_MB, after_MB);
  return after_MB - before_MB;
}

}  // namespace

FIRN_BENCH(page_load) try {
  int tabs = 16, messages = 100'000;
  double seconds = 20.0;
  for (int n = 1; n + 1 < argc; n += 2) {
    const std::string option = argv[n];
    if (option == "--tabs") tabs = std::atoi(argv[n + 1]);
    if (option == "--seconds") seconds = std::atof(argv[n + 1]);
    if (option == "--messages") messages = std::atoi(argv[n + 1]);
  }
  const test::TempFolder place;
  FalsePrint print(place.path() / "runs");
  const PageProcess page(print.folder.path());
  int layer = 0;
  print.map(layer);
  const double percent = load(print, page, tabs, seconds, Kind::kMaps, false, layer);
  load(print, page, tabs, seconds, Kind::kMaps, true, layer);
  load(print, page, tabs, seconds, Kind::kRows, false, layer);
  const double grown_MB = memory(print, page, messages);
  return percent <= 5.0 && grown_MB < 8.0 ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "page_load: %s\n", e.what());
  return 1;
}

}  // namespace firn::bench::page_load
