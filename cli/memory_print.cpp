#include "cli/memory_print.h"

#include <time.h>

#include <memory>
#include <stdexcept>

#include "cli/node_makers.h"
#include "cli/plant_world.h"
#include "core/grid/npy.h"
#include "firn/layer_metrics_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/run_start_t.hpp"
#include "plant/setup.h"

namespace firn {
namespace {

constexpr std::int64_t kRunId = 1;  // nothing else is on this bus
constexpr double kLongestPrint_s = 3600.0 * 24 * 30;

std::int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

std::vector<std::unique_ptr<NodeHost>> make_hosts(const Experiment& e, const Blobs& inputs) {
  std::vector<std::unique_ptr<NodeHost>> hosts;
  const std::string config = dump(e);
  for (const NamedMaker& maker : taking_part(e)) {
    hosts.push_back(std::make_unique<NodeHost>(maker.id, maker.make(config, inputs), kRunId, nullptr));
    if (maker.id == NodeId::kController) hosts.back()->set_stopwatch(thread_cpu_ns);
  }
  return hosts;
}

template <class Message>
bool decode(std::span<const std::byte> bytes, Message& m) {
  return m.decode(bytes.data(), 0, int(bytes.size())) >= 0;
}

LayerTruth layer_truth(int layer, const plant::Truth& t, Time now, const HeightMap& target, const Mask& mask) {
  return {layer, t.droplets_fired, t.volume_mm3, now.s(), error_stats(t.height, target, mask)};
}

}  // namespace

MemoryPrintReport print_in_memory(const Experiment& e, const Blobs& inputs, const MemoryPrintOptions& options) {
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  PlantWorld world(plant::World(plant::world_config(e), nullptr));
  Lab lab(&world);
  const auto hosts = make_hosts(e, inputs);
  for (const auto& host : hosts) lab.add(host.get());

  MemoryPrintReport report;
  run_end_t end{};
  int layers_measured = 0;
  lab.set_tap([&](std::string_view channel, std::span<const std::byte> bytes, Time) {
    if (options.tap) options.tap(channel, bytes);
    if (channel == channels::kRunEnd.name) decode(bytes, end);
    if (layer_metrics_t m; channel == channels::kLayerMetrics.name && decode(bytes, m)) layers_measured = m.layer;
    if (layer_plan_t plan; channel == channels::kLayerPlan.name && decode(bytes, plan)) report.iterations += plan.iterations;
  });
  Outbox launcher(NodeId::kLauncher, kRunId);
  launcher.begin(Time{}, 0);
  run_start_t started;
  started.name = e.run.name;
  started.scheme = e.control.scheme;
  launcher.send(channels::kRunStart, started);
  lab.publish(launcher.at(0).channel, launcher.at(0).bytes);
  lab.start(0, Time{});

  const auto over = [&] {
    for (const auto& host : hosts)
      if ((host->id() == NodeId::kScheduler || host->id() == NodeId::kSafety) && !host->finished()) return false;
    return true;
  };
  const Time limit = Time{}.after_s(kLongestPrint_s);
  while (!over()) {
    if (!lab.step(limit)) throw std::runtime_error("the lab stands still at " + std::to_string(lab.now().s()) + " s of node time");
    if (options.series && layers_measured > int(report.series.size()))
      report.series.push_back(layer_truth(layers_measured, world.world().truth(), lab.now(), target, mask));
  }

  plant::Truth truth = world.world().truth();
  report.result = result_of(end.outcome, end.layers, end.reason);
  report.error = error_stats(truth.height, target, mask);
  report.droplets = truth.droplets_fired;
  report.droplets_missed = truth.droplets_missed;
  report.volume_mm3 = truth.volume_mm3;
  report.node_s = lab.now().s();
  for (const auto& host : hosts) report.decide_cpu_s += double(host->handler_ns()) * 1e-9;
  if (options.materials) report.materials = world.world().materials();
  if (options.surface) report.surface = std::move(truth.height);
  return report;
}

}  // namespace firn
