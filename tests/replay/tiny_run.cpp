#include "tests/replay/tiny_run.h"

#include <array>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>

#include "config/experiment.h"
#include "files/digest.h"
#include "files/record/event_log.h"
#include "files/record/record_file.h"
#include "firn/answer_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/height_profile_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "lcmtypes/convert.h"
#include "runtime/lab.h"

namespace firn::test {
namespace {

constexpr TimerId kNextScan{3};

grid_t tiny_grid() { return to_message(GridSpec{kTinyColumns, kTinyRows, 0.25, 0.25, 0.0, 0.0}); }

// Asks for a scan, takes the plan, waits as long as a layer takes, asks again.
class TinyScheduler : public Node {
 public:
  explicit TinyScheduler(int layers) : layers_(layers) {
    subscribe(channels::kLayerPlan, this);
    subscribe(channels::answer(NodeId::kLaserProfiler), this);
  }
  void start(const Start&, Time now, Outbox& out) override { out.wake_at(kNextScan, now.after_s(1.0)); }
  void on(const answer_t&, Time, Outbox&) { ++answers_; }
  void on(const layer_plan_t& plan, Time now, Outbox& out) {
    double drops = 0;
    for (auto d : plan.drops) drops += d;
    if (plan.layer <= layers_) return out.wake_at(kNextScan, now.after_s(0.5 + 0.01 * drops));
    run_end_t end{};
    end.layers = layers_;
    end.reason = "part complete, " + std::to_string(answers_) + " scans";
    out.send(channels::kRunEnd, end);
    out.finish(0, "part complete");
  }
  void wake(TimerId, Time, Outbox& out) override {
    profiler_command_t c{};
    c.verb = 1;
    c.command_id = c.scan_id = ++scans_;
    c.layer = std::int32_t(scans_ - 1);
    c.rows = kTinyRows;
    c.pitch_y_mm = 0.25;
    out.send(channels::kProfilerCommand, c);
  }

 private:
  int layers_, answers_ = 0;
  std::int64_t scans_ = 0;
};

// Its instrument sends lines of floats, in any split.
class TinyProfiler : public Node {
 public:
  TinyProfiler() { subscribe(channels::kProfilerCommand, this); }
  std::vector<std::string> ports() const override { return {"laser_profiler"}; }
  void on(const profiler_command_t& c, Time, Outbox& out) {
    command_ = c;
    row_ = 0;
    out.write(PortId{0}, std::as_bytes(std::span("SCAN\r\n", 6)));
  }
  void on_io(PortId, std::span<const std::byte> bytes, Time now, Outbox& out) override {
    held_.insert(held_.end(), bytes.begin(), bytes.end());
    constexpr std::size_t kLine = kTinyColumns * sizeof(float);
    while (held_.size() >= kLine) {
      height_profile_t p{};
      p.n = kTinyColumns;
      p.layer = command_.layer;
      p.scan_id = command_.scan_id;
      p.row = row_++;
      p.rows = kTinyRows;
      p.sample_utime_us = now.us;
      p.dx_mm = 0.25;
      p.z_mm.resize(kTinyColumns);
      std::memcpy(p.z_mm.data(), held_.data(), kLine);
      held_.erase(held_.begin(), held_.begin() + kLine);
      out.send(channels::kHeightProfile, p);
    }
    if (row_ != kTinyRows) return;
    answer_t a{};
    a.node = "laser_profiler";
    a.command_id = command_.command_id;
    a.outcome = 1;
    out.send(channels::answer(NodeId::kLaserProfiler), a);
    row_ = 0;
  }

 private:
  profiler_command_t command_{};
  int row_ = 0;
  std::vector<std::byte> held_;
};

class TinyMapper : public Node {
 public:
  TinyMapper() : map_(kTinyColumns * kTinyRows) { subscribe(channels::kHeightProfile, this); }
  void on(const height_profile_t& p, Time, Outbox& out) {
    if (p.row < 0 || p.row >= kTinyRows || p.n != kTinyColumns) return;
    std::copy(p.z_mm.begin(), p.z_mm.end(), map_.begin() + p.row * kTinyColumns);
    if (p.row != kTinyRows - 1) return;
    height_map_t m{};
    m.n = kTinyColumns * kTinyRows;
    m.layer = p.layer;
    m.map_id = p.scan_id;
    m.sample_utime_us = p.sample_utime_us;
    m.grid = tiny_grid();
    m.measured_fraction = 1.0;
    m.height_mm = map_;
    m.quality.assign(map_.size(), 0);
    out.send(channels::kHeightMap, m);
  }

 private:
  std::vector<float> map_;
};

// Fires where the gain times the error, summed over the layers, is above a threshold.
class TinyController : public Node {
 public:
  TinyController(double kp, float target_mm) : kp_(kp), target_mm_(target_mm) {
    subscribe(channels::kHeightMap, this);
  }
  void on(const height_map_t& m, Time, Outbox& out) {
    layer_plan_t p{};
    p.n = m.n;
    p.layer = m.layer + 1;
    p.map_id = m.map_id;
    p.grid = m.grid;
    p.passes = 1;
    integral_.resize(m.height_mm.size());
    for (std::size_t c = 0; c < m.height_mm.size(); ++c) {
      integral_[c] += target_mm_ - m.height_mm[c];
      p.objective_mm += integral_[c];
      p.drops.push_back(kp_ * integral_[c] > 0.01 ? 1 : 0);
    }
    out.send(channels::kLayerPlan, p);
  }

 private:
  double kp_;
  float target_mm_;
  std::vector<double> integral_;
};

// Sends the lines of a surface that grows, each split in two.
class TinyWorld : public LabWorld {
 public:
  void connect(std::string_view, Time) override {}
  void disconnect(std::string_view, Time) override {}
  void receive(std::string_view, std::span<const std::byte>, Time now) override {
    ++scans_;
    rows_ = 0;
    next_ = now.after_s(0.01);
  }
  Time next_event() const override { return next_; }
  void advance(Time now, const Send& send) override {
    std::array<float, kTinyColumns> z{};
    for (std::size_t i = 0; i < z.size(); ++i)
      z[i] = 0.004F * float(scans_) * (1.0F + 0.03F * float(i % 3) + 0.02F * float(rows_));
    const auto bytes = std::as_bytes(std::span(z));
    send("laser_profiler", bytes.first(7), now, false);
    send("laser_profiler", bytes.subspan(7), now, false);
    next_ = ++rows_ < kTinyRows ? now.after_s(0.01) : Time::never();
  }

 private:
  Time next_ = Time::never();
  int scans_ = 0, rows_ = 0;
};

class FileSink : public WalSink {
 public:
  explicit FileSink(const std::filesystem::path& path) : writer_(path, record::RecordWriter::Mode::kCreate) {}
  void append(WalKind kind, std::span<const std::byte> payload) override {
    writer_.append(std::uint16_t(kind), payload);
  }
  void sync() override {}

 private:
  record::RecordWriter writer_;
};

Experiment read(const std::string& config) { return parse_experiment(config, "config"); }

std::unique_ptr<Node> make_scheduler(const std::string& config, const Blobs&) {
  return std::make_unique<TinyScheduler>(read(config).control.max_layers);
}
std::unique_ptr<Node> make_mapper(const std::string&, const Blobs&) { return std::make_unique<TinyMapper>(); }
std::unique_ptr<Node> make_profiler(const std::string&, const Blobs&) {
  return std::make_unique<TinyProfiler>();
}
std::unique_ptr<Node> make_controller(const std::string& config, const Blobs& blobs) {
  float target_mm = 0;
  std::memcpy(&target_mm, blob(blobs, "target").bytes.data(), sizeof target_mm);
  return std::make_unique<TinyController>(read(config).control.smf.kp, target_mm);
}

constexpr replay::NodeMaker kMakers[] = {{"scheduler", make_scheduler},
                                         {"surface_mapper", make_mapper},
                                         {"controller", make_controller},
                                         {"laser_profiler", make_profiler}};

}  // namespace

replay::RunVerdict replay_tiny(const std::filesystem::path& run, replay::ReplayOptions options) {
  options.makers = kMakers;
  return replay::replay_run(run, options);
}

std::filesystem::path scratch_folder(const std::string& name) {
  const std::filesystem::path folder = std::filesystem::path(FIRN_BINARY_DIR) / "scratch" / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

void record_tiny_run(const std::filesystem::path& run, const TinyOptions& options) {
  std::filesystem::create_directories(run / "nodes");
  std::filesystem::create_directories(run / "inputs");
  Experiment experiment;
  experiment.control.max_layers = options.layers;
  experiment.control.smf.kp = options.kp;
  WalHead head;
  head.run_id = options.run_id;
  head.commit = "0123abc";
  head.platform = "test";
  head.config_toml = dump(experiment);
  const float target_mm = 0.02F;
  const auto target = std::as_bytes(std::span(&target_mm, 1));
  head.blobs = {{"target", sha256_hex(target)}};
  std::ofstream(run / "experiment.toml") << head.config_toml;
  std::ofstream(run / "provenance.json") << "{\"run_id\": " << options.run_id << ", \"inputs\": []}\n";
  std::ofstream(run / "inputs" / sha256_hex(target), std::ios::binary)
      .write(reinterpret_cast<const char*>(&target_mm), sizeof target_mm);
  const Blobs blobs{{"target", sha256_hex(target), {target.begin(), target.end()}}};

  TinyWorld world;
  Lab lab(&world);
  std::vector<std::unique_ptr<FileSink>> sinks;
  std::vector<std::unique_ptr<NodeHost>> hosts;
  for (const replay::NodeMaker& m : kMakers) {
    sinks.push_back(std::make_unique<FileSink>(run / "nodes" / (std::string(m.name) + ".wal")));
    hosts.push_back(std::make_unique<NodeHost>(find_node(m.name)->id, m.make(head.config_toml, blobs),
                                               options.run_id, sinks.back().get()));
    lab.add(hosts.back().get());
  }
  std::optional<record::EventLogWriter> log;
  if (options.log) {
    log.emplace(run / "log.lcm");
    lab.set_tap([&](std::string_view channel, std::span<const std::byte> bytes, Time now) {
      log->append(now.us, channel, bytes);
    });
  }
  const NodeId last = NodeId::kScheduler;
  Time now;
  for (int incarnation = 0; incarnation <= options.resumes; ++incarnation) {
    for (std::size_t n = 0; n < hosts.size(); ++n) {
      head.node = hosts[n]->name();
      head.incarnation = incarnation;
      std::vector<std::byte> bytes;
      encode_head(head, bytes);
      sinks[n]->append(WalKind::kHead, bytes);
    }
    lab.start(incarnation, now);
    // between two scans nothing is on its way
    now = incarnation < options.resumes ? now.after_s(1.2) : Time{}.after_s(100'000);
    lab.run({&last, 1}, now);
  }
  if (log) log->close();
}

}  // namespace firn::test
