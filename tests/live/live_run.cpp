#include "tests/live/live_run.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "config/devices.h"
#include "config/include.h"
#include "config/labs.h"
#include "files/exit_codes.h"
#include "print/inputs/ice_inputs.h"
#include "print/labs/full_product.h"
#include "print/live/bus_check.h"
#include "print/live/busy_machine.h"
#include "runtime/lossy.h"
#include "runtime/run_clock.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/watched_jet.h"

namespace firn::test {
namespace {

const std::filesystem::path kLiveExperiments = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

/// A process that has ended but that nobody has waited for counts as gone.
bool alive(int pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(in, text);
  const auto at = text.rfind(')');
  return at != std::string::npos && at + 2 < text.size() && text[at + 2] != 'Z' && text[at + 2] != 'X';
}

}  // namespace

Experiment tiny_part(std::uint64_t seed) {
  Experiment e;
  e.run.name = "tiny";
  e.run.time_scale = 10.0;
  e.grid = {9, 9, 0.263256, 0.263256, 0.0, 0.0};
  e.part.shape.kind = "cuboid";
  e.part.shape.width_mm = 1.5;
  e.part.shape.depth_mm = 1.5;
  e.part.shape.height_mm = 0.03;
  e.control.scheme = "mpc";
  e.process.scan_speed_mm_s = 3.0;  // 9 ms of wall time per row: the profiler keeps only its newest one
  e.process.max_rescans = 4;
  e.plant.seed = seed;
  return e;
}

Experiment tiny_part_beside_centres(std::uint64_t seed) {
  Experiment e = tiny_part(seed);
  e.control.scheme = "pattern";
  e.control.pattern.seed = seed;
  e.actuation.offsets = OffsetKind::kGrid;
  e.actuation.positions_x = e.actuation.positions_y = 3;
  e.actuation.small_share = seed % 2 ? 0.45 : 0.0;
  return e;
}

Experiment tiny_part_of_two_inks(std::uint64_t seed) {
  Experiment e = tiny_part(seed);
  e.part.shape.height_mm = 0.015;
  e.geometry.solid.kind = "pipe";
  e.geometry.solid.outer_diameter_mm = 1.2;
  e.geometry.solid.inner_diameter_mm = 0.5;
  e.process.sub_patterns = 4;
  return e;
}

Experiment tiny_watched_part(std::uint64_t seed) {
  Experiment e = tiny_part(seed);
  watch_jet(e);
  return e;
}

Experiment tiny_lines(std::uint64_t seed) {
  Experiment e = load_experiment(
      kLiveExperiments / "aerosol-meander.toml",
      {"aerosol.job=aerosol-lines.json", "aerosol.layers=3", "grid.nx=250", "grid.ny=80", "run.time_scale=10",
       "process.scan_speed_mm_s=0.4", "process.max_rescans=4",  // 5 ms of wall time per row
       "heater.low_degC=-40",                                   // warm at once
       "camera.use=on", "plant.camera.width_px=64", "plant.camera.height_px=64", "plant.camera.um_per_px=6"});
  e.plant.seed = seed;
  return e;
}

Experiment tiny_lines_by_camera(std::uint64_t seed) {
  Experiment e = tiny_lines(seed);
  e.devices.laser_profiler = kNoInstrument;
  e.aerosol.width_by = control::WidthActuator::kSpeed;
  e.plant.camera.width_px = e.plant.camera.height_px = 128;  // there is ground beside the line
  e.aerosol.camera_um_per_px = e.plant.camera.um_per_px;
  return e;
}

Experiment tiny_ice(std::uint64_t seed) {
  Experiment e = load_experiment(kLiveExperiments / "ice-small.toml",
                                 {"run.time_scale=10", "ice.interval_layers=3", "ice.measure_spacing_mm=3"});
  e.plant.seed = seed;
  return e;
}

Blobs tiny_ice_inputs(Experiment& e, const std::filesystem::path& scratch) {
  const auto stl = mesh_bytes::binary_stl(prism(4, 1.44f, 0.0f, 0.0f, [](std::uint32_t) { return 6.5; }));
  std::ofstream(scratch / "block.stl", std::ios::binary)
      .write(reinterpret_cast<const char*>(stl.data()), std::streamsize(stl.size()));
  e.ice.mesh = (scratch / "block.stl").string();
  Blobs inputs = make_inputs(full_product(), e, kLiveExperiments);
  place_ice_field(e, inputs);
  return inputs;
}

std::string multicast_refused() {
  static const std::string why = check_multicast();
  return why;
}

LiveRun::LiveRun(const Experiment& experiment) : lines(prints_lines(experiment)) {
  std::string name = (std::filesystem::temp_directory_path() / "firn-live-XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("mkdtemp");
  root_ = name;
  const std::string longer_than_a_socket_address(110, 'x');
  Experiment e = experiment;
  const Blobs inputs =
      prints_paths(e) ? tiny_ice_inputs(e, root_) : make_inputs(full_product(), e, kLiveExperiments);
  folder_ = runs::RunFolder::create(root_ / longer_than_a_socket_address, e, inputs, {"test"});
}

LiveRun::~LiveRun() {
  for (const auto& [name, pid] : pids_)
    if (alive(pid)) ::kill(pid, SIGKILL);
  if (launcher_ > 0) {
    ::kill(launcher_, SIGKILL);
    ::waitpid(launcher_, nullptr, 0);
  }
  if (!std::getenv("FIRN_KEEP_RUNS")) std::filesystem::remove_all(root_);
}

void LiveRun::start(bool resume, const std::filesystem::path& programs) {
  pids_.clear();
  ++incarnation_;
  std::filesystem::remove(path() / "pids");
  std::filesystem::remove(root_ / "page");
  launcher_ = ::fork();
  if (launcher_ != 0) {
    ::setpgid(launcher_, launcher_);
    return;
  }
  ::setpgid(0, 0);
  if (std::filesystem::exists(disk_file())) {
    ::setenv("LD_PRELOAD", FIRN_DISK_TROUBLE, 1);  // of the processes that are started from here
    ::setenv("FIRN_TROUBLE_FOLDER", path().c_str(), 1);
    ::setenv("FIRN_TROUBLE_FILE", disk_file().c_str(), 1);
  }
  const int err = ::open((root_ / "launcher.err").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  ::dup2(err, STDERR_FILENO);
  try {
    LaunchOptions options;
    options.resume = resume;
    options.bus_url = bus_url;
    options.faults = faults;
    options.programs = programs;
    options.page_token = page_token;
    options.on_page = [&](const std::string& address) { std::ofstream(root_ / "page") << address << "\n"; };
    options.on_start = [&](const std::map<std::string, int>&) {
      std::ofstream(root_ / ("started" + std::to_string(incarnation_))) << "x";
    };
    const LaunchReport report = launch(full_product(), runs::RunFolder::open(path()), options);
    std::fprintf(stderr, "%s: %s\n", report.result.outcome.c_str(), report.result.reason.c_str());
    ::_exit(report.result.status);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "launcher: %s\n", e.what());
    ::_exit(1);
  }
}

bool LiveRun::wait_started() {
  while (!std::filesystem::exists(root_ / ("started" + std::to_string(incarnation_)))) {
    if (!running()) return false;
    ::usleep(5000);
  }
  std::ifstream in(path() / "pids");
  std::string name;
  for (int pid; in >> name >> pid;) pids_[name] = pid;
  return !pids_.empty();
}

std::string LiveRun::page_address() {
  for (std::string line; running(); ::usleep(5000))
    if (std::ifstream in(root_ / "page"); std::getline(in, line) && !in.eof()) return line;
  return "";
}

std::int64_t LiveRun::kill(const std::string& name) {
  const std::int64_t now = monotonic_ns();
  ::kill(pids_.at(name), SIGKILL);
  return now;
}

std::vector<std::string> LiveRun::processes() const {
  std::vector<std::string> names;
  for (const auto& [name, pid] : pids_) names.push_back(name);
  return names;
}

void LiveRun::set_disk(Disk state) {
  const int fd = ::open(disk_file().c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  const char byte = char(state);
  if (fd < 0 || ::pwrite(fd, &byte, 1, 0) != 1)
    throw std::runtime_error(disk_file().string() + ": cannot be written");
  ::close(fd);
}

void LiveRun::interrupt() { ::kill(launcher_, SIGINT); }

void LiveRun::signal_all(int signal) { ::kill(-launcher_, signal); }

bool LiveRun::running() { return launcher_ > 0 && alive(launcher_); }

int LiveRun::wait() {
  int status = 0;
  ::waitpid(launcher_, &status, 0);
  launcher_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// "" if the last stop was of another kind: the words are those of a print that names its lateness, and of
// drivers whose instrument's answer was read too late.
std::string LiveRun::late_stop() const {
  constexpr std::string_view kLate[] = {
      "stood still", "said nothing",  "no good reply",    "no answer",
      "link lost",   "no height map", "rows of its scan", "has a clock that is known to"};
  std::string last;
  std::istringstream lines(said());
  for (std::string line; std::getline(lines, line);)
    if (line.find("stopped safely") != line.npos) last = line;
  const bool named = !busy_words(last, 0, 2.0, 1).empty() ||
                     std::ranges::any_of(kLate, [&](auto words) { return last.find(words) != last.npos; });
  return named ? last : "";
}

int LiveRun::wait_finished() {
  constexpr int kMostLateStops = 3;
  constexpr double kLoaded_s = 0.01;  // an idle computer wakes a thread within a millisecond
  for (;;) {
    const int status = wait();
    const bool loaded = lateness_.longest_s() > kLoaded_s;
    const std::string why = loaded && status == kSafetyStop ? late_stop() : "";
    if (why.empty() || late_stops_ == kMostLateStops) return status;
    ++late_stops_;
    std::printf("%s: somebody came too late, as on a loaded computer; resumed: %s\n", path().c_str(),
                why.c_str());
    wait_all_gone();
    start(true);
    wait_started();
  }
}

void LiveRun::wait_all_gone() {
  for (const auto& [name, pid] : pids_)
    while (alive(pid)) ::usleep(5000);
}

std::string LiveRun::said() const {
  std::ifstream in(root_ / "launcher.err");
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

std::int64_t LiveRun::node_time_us(std::int64_t mono_ns) const {
  std::ifstream in(path() / "clocks");
  std::string line, last;
  while (std::getline(in, line)) last = line;
  std::istringstream words(last);
  std::int64_t incarnation = 0, epoch_ns = 0, offset_us = 0;
  double scale = 1.0;
  words >> incarnation >> epoch_ns >> offset_us >> scale;
  return RunClock(epoch_ns, offset_us, scale).at_ns(mono_ns).us;
}

std::uint64_t LiveRun::injected() const {
  std::uint64_t sum = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path() / "nodes")) {
    if (entry.path().extension() != ".faults") continue;
    std::ifstream in(entry.path());
    std::string text;
    std::getline(in, text);
    sum += parse_lossy_counts(text).injected();
  }
  return sum;
}

}  // namespace firn::test
