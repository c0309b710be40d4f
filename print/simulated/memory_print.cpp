#include "print/simulated/memory_print.h"

#include <time.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "config/labs.h"
#include "core/grid/npy.h"
#include "core/slice/coverage/footprint.h"
#include "firn/layer_metrics_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/run_start_t.hpp"
#include "plant/world/ice_lab.h"
#include "plant/world/setup.h"
#include "print/folder/taking_part.h"
#include "print/simulated/line_truth.h"
#include "print/simulated/plant_world.h"
#include "print/simulated/validity_words.h"
#include "replay/ice_error.h"

namespace firn {
namespace {

constexpr std::int64_t kRunId = 1;  // nothing else is on this bus
constexpr double kLongestPrint_s = 3600.0 * 24 * 30;
constexpr double kSafetyWall_s = 10.0;  // an instrument that sends nothing more is never reported safe

std::int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

std::vector<std::unique_ptr<NodeHost>> make_hosts(const Product& product, const Experiment& e,
                                                  const Blobs& inputs) {
  std::vector<std::unique_ptr<NodeHost>> hosts;
  const std::string config = dump(e);
  for (const NamedMaker& maker : taking_part(product, e)) {
    hosts.push_back(std::make_unique<NodeHost>(maker.id, maker.make(config, inputs), kRunId, nullptr));
    if (maker.id == NodeId::kController) hosts.back()->set_stopwatch(thread_cpu_ns);
  }
  return hosts;
}

template <class Message>
bool decode(std::span<const std::byte> bytes, Message& m) {
  return m.decode(bytes.data(), 0, int(bytes.size())) >= 0;
}

/// The true error after a layer: of droplets about the final target, of paths about the nominal height so
/// far.
class Judge {
 public:
  Judge(const Experiment& e, const Blobs& inputs) : pitch_mm_(e.ice.pitch_mm) {
    if (prints_paths(e)) {
      paths_ = slice::decode_print_paths(blob(inputs, "paths").bytes);
      return;
    }
    target_ = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
    mask_ = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  }

  /// And the surface that it is of.
  ErrorStats error(const plant::World& world, int layer, HeightMap& surface) const {
    if (!world.ice()) return error_stats(surface, target_, mask_);
    const slice::LayerPaths* paths = slice::find_layer(paths_, layer);
    if (!paths) return {};
    surface = world.ice()->height_over(slice::footprint_grid(*paths, pitch_mm_));
    return replay::ice_error(surface, *paths, pitch_mm_);
  }

  /// What lies beside the part: of droplets their surface, of paths the ice without its scaffold.
  OutlineStats outline(const plant::World& world, const plant::Truth& truth) const {
    if (!world.ice())
      return outline_stats(truth.wide, target_, mask_, truth.fine.size() > 0 ? &truth.fine : nullptr);
    const replay::NominalPart part =
        replay::nominal_part(paths_, replay::kOutlineCell_mm, replay::kOutlineMargin_mm);
    return outline_stats(world.ice()->thickness_over(part.target.spec, 0), part.target, part.mask);
  }

  LayerTruth truth(const plant::World& world, int layer, Time now) const {
    plant::Truth t = world.truth();
    return {layer, t.droplets_fired, t.volume_mm3, now.s(), error(world, layer, t.height), 0.0, 0.0};
  }

 private:
  double pitch_mm_;
  slice::PrintPaths paths_;
  HeightMap target_;
  Mask mask_;
};

}  // namespace

MemoryPrintReport print_in_memory(const Product& product, const Experiment& e, const Blobs& inputs,
                                  const MemoryPrintOptions& options) {
  const Judge judge(e, inputs);
  plant::WorldConfig nature = plant::world_config(e, inputs);
  if (options.nature) options.nature(nature);
  PlantWorld world(plant::World(nature, nullptr));
  Lab lab(&world);
  const auto hosts = make_hosts(product, e, inputs);
  for (const auto& host : hosts) lab.add(host.get());

  MemoryPrintReport report;
  run_end_t end{};
  layer_metrics_t measured{};
  std::optional<LineJudge> lines;
  if (prints_lines(e)) lines.emplace(e, inputs);
  lab.set_tap([&](std::string_view channel, std::span<const std::byte> bytes, Time) {
    if (options.tap) options.tap(channel, bytes);
    if (channel == channels::kRunEnd.name) decode(bytes, end);
    if (channel == channels::kDepositionReport.name) ++report.passes;
    if (layer_metrics_t m; channel == channels::kLayerMetrics.name && decode(bytes, m)) measured = m;
    if (line_plan_t plan; lines && channel == channels::kLinePlan.name && decode(bytes, plan))
      lines->take(plan);
    if (path_report_t path; lines && channel == channels::kPathReport.name && decode(bytes, path))
      lines->take(path);
    if (layer_plan_t plan; channel == channels::kLayerPlan.name && decode(bytes, plan))
      report.iterations += plan.iterations;
  });
  Outbox launcher(NodeId::kLauncher, kRunId);
  launcher.begin(Time{}, 0);
  run_start_t started{};
  started.name = e.run.name;
  started.scheme = e.control.scheme;
  launcher.send(channels::kRunStart, started);
  lab.publish(launcher.at(0).channel, launcher.at(0).bytes);
  lab.start(0, Time{});

  std::optional<Time> scheduler_done;
  const auto over = [&] {
    bool all = true;
    for (const auto& host : hosts) {
      if (host->id() == NodeId::kScheduler && host->finished() && !scheduler_done) scheduler_done = lab.now();
      if ((host->id() == NodeId::kScheduler || host->id() == NodeId::kSafety) && !host->finished())
        all = false;
    }
    return all ||
           (scheduler_done && seconds_between(*scheduler_done, lab.now()) > kSafetyWall_s * e.run.time_scale);
  };
  const Time limit = Time{}.after_s(kLongestPrint_s);
  while (!over()) {
    if (!lab.step(limit))
      throw std::runtime_error("the lab stands still at " + std::to_string(lab.now().s()) +
                               " s of node time");
    if (lines && measured.layer > lines->layer()) lines->take(measured.layer, world.world().truth().height);
    if (!options.series || measured.layer <= (report.series.empty() ? 0 : report.series.back().layer))
      continue;
    report.series.push_back(judge.truth(world.world(), measured.layer, lab.now()));
    report.series.back().deposit_s = measured.deposit_s;
    report.series.back().measure_s = measured.scan_s;
    if (options.ice_each && options.ice_over && world.world().ice())
      report.ice_each.push_back(world.world().ice()->thickness_over(*options.ice_over, 0));
  }

  plant::Truth truth = world.world().truth();
  report.result = runs::result_of(end.outcome, end.layers, end.reason);
  report.result.reason += validity_words(truth.validity);
  report.error = judge.error(world.world(), prints_paths(e) ? measured.layer : end.layers, truth.height);
  if (options.outline) report.outline = judge.outline(world.world(), truth);
  report.droplets = truth.droplets_fired;
  report.droplets_missed = truth.droplets_missed;
  report.volume_mm3 = truth.volume_mm3;
  report.node_s = lab.now().s();
  for (const auto& host : hosts) report.decide_cpu_s += double(host->handler_ns()) * 1e-9;
  if (lines) {
    report.lines = lines->result();
    report.looks = lines->looks();
    report.paths = lines->paths();
  }
  if (options.materials) report.materials = world.world().materials();
  if (options.ice_over && world.world().ice())
    report.ice = world.world().ice()->thickness_over(*options.ice_over, 0);
  if (options.surface) report.surface = std::move(truth.height);
  return report;
}

}  // namespace firn
