// The live loop over UDP: HEIGHT_MAP out to LAYER_PLAN in, on a grid of 100 x 100, with the real controller
// process, beside the time that its handler alone takes (from its write-ahead file).
//   loop_latency [--maps N] [--set KEY=VALUE]…
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "config/include.h"
#include "core/grid/random.h"
#include "files/record/record_file.h"
#include "firn/height_map_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/convert.h"
#include "print/labs/full_product.h"
#include "print/process/bus_port.h"
#include "print/process/child_process.h"
#include "procs/bus/lcm_bus.h"
#include "runs/folder/run_folder.h"
#include "runtime/process_args.h"
#include "runtime/run_clock.h"
#include "runtime/station.h"
#include "tests/bench/bench.h"

namespace firn::bench::loop_latency {

namespace {

using namespace firn;

// Surfaces as a closed loop meets them: one to a few layers short of the target, rough, or on a slope.
HeightMap surface(const GridSpec& g, double target_mm, int n) {
  RandomStream random(1, Purpose::kInstance, std::uint32_t(n));
  HeightMap h(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double short_mm = n % 3 == 0   ? 0.0038 + 0.001 * random.normal()
                              : n % 3 == 1 ? 0.0076 * i / g.nx + 0.0005 * random.normal()
                                           : 0.0076 * random.uniform();
      h.at(i, j) = target_mm - short_mm;
    }
  return h;
}

double quantile(std::vector<double> x, double q) {
  std::sort(x.begin(), x.end());
  return x[std::min(x.size() - 1, std::size_t(q * double(x.size())))];
}

std::vector<double> handler_ms(const std::filesystem::path& wal) {
  const record::MappedFile file(wal);
  record::RecordReader reader(file.bytes());
  std::vector<double> ms;
  while (const auto r = reader.next())
    if (WalKind(r->kind) == WalKind::kOutputs) {
      const WalOutputs w = decode_outputs(r->payload);
      for (const Output& o : decode_output_list(w.body))
        if (o.kind == OutputKind::kSend && o.channel == channels::kLayerPlan.name)
          ms.push_back(double(w.handler_ns) * 1e-6);
    }
  return ms;
}

}  // namespace

FIRN_BENCH(loop_latency) {
  int maps = 300;
  std::vector<std::string> overrides = {"grid.nx=100",          "grid.ny=100",        "part.shape=cuboid",
                                        "part.width_mm=26.3",   "part.depth_mm=26.3", "part.height_mm=0.2",
                                        "run.name=loop-latency"};
  for (int n = 1; n + 1 < argc; n += 2) {
    if (std::string(argv[n]) == "--maps") maps = std::atoi(argv[n + 1]);
    if (std::string(argv[n]) == "--set") overrides.push_back(argv[n + 1]);
  }
  const std::filesystem::path file = FIRN_SOURCE_DIR "/experiments/cuboid.toml";
  const Experiment e = load_experiment(file, overrides);
  const auto root = std::filesystem::temp_directory_path() / fmt::format("firn-loop-{}", getpid());
  const runs::RunFolder run =
      runs::RunFolder::create(root, e, make_inputs(full_product(), e, file.parent_path()), {"loop_latency"});

  ProcessArgs args;
  args.options.node = NodeId::kController;
  args.options.run_dir = run.path().string();
  args.options.run_id = run.run_id();
  args.options.epoch_ns = monotonic_ns();
  args.options.control_fd = ChildProcess::kControlFd;
  args.bus_url = default_bus_url(free_bus_port(run.run_id())) + "&key=none";
  for (const Blob& b : run.inputs()) args.blobs.emplace_back(b.role, b.sha256);

  std::int64_t answered = 0;
  LcmBus bus(args.bus_url);
  ProcessOptions own = args.options;
  own.node = NodeId::kSurfaceMapper;
  Station mapper(own, bus, [&](const ChannelInfo&, std::span<const std::byte> bytes) {
    layer_plan_t plan{};
    if (plan.decode(bytes.data(), 0, int(bytes.size())) > 0) answered = plan.map_id;
  });
  mapper.subscribe(channels::kLayerPlan.name);
  mapper.join();
  ChildProcess controller("controller", FIRN_BINARY_DIR "/bin/controller", to_arguments(args),
                          run.path() / "nodes" / "controller.err");
  const auto line = [&](const char* wanted) {
    for (int n = 0; n < 3000; ++n) {
      while (const auto l = controller.control().next())
        if (*l == wanted) return true;
      usleep(10000);
    }
    return false;
  };
  if (!line("READY")) return fmt::print(stderr, "the controller is not ready\n"), 1;
  controller.control().say("START");

  std::vector<double> ms;
  for (int n = 1; n <= maps; ++n) {
    height_map_t m{};
    m.layer = 10;
    m.attempt = n;
    m.map_id = n;
    m.measured_fraction = 1.0;
    m.noise_std_mm = 0.001;
    set_height(m, surface(e.grid, e.part.shape.height_mm, n));
    m.quality.assign(m.height_mm.size(), 0);
    const auto began = std::chrono::steady_clock::now();
    mapper.send(channels::kHeightMap, m);
    while (answered != n) {
      mapper.service();
      if (answered == n) break;
      pollfd p{mapper.fd(), POLLIN, 0};
      poll(&p, 1, 1);
      if (std::chrono::steady_clock::now() - began > std::chrono::seconds(20))
        return fmt::print(stderr, "no plan for map {}\n", n), 1;
    }
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count());
  }
  controller.control().say("STOP the bench is over");
  for (int n = 0; n < 300 && controller.running(); ++n) usleep(10000);
  const std::vector<double> alone = handler_ms(run.wal_path("controller"));
  fmt::print("{} x {} cells, {} maps over {}, kernel receive buffer {} bytes\n", e.grid.nx, e.grid.ny, maps,
             args.bus_url, granted_receive_buffer());
  fmt::print("HEIGHT_MAP out to LAYER_PLAN in: p50 {:.2f} ms, p99 {:.2f} ms\n", quantile(ms, 0.5),
             quantile(ms, 0.99));
  fmt::print("decision alone (handler):        p50 {:.2f} ms, p99 {:.2f} ms\n", quantile(alone, 0.5),
             quantile(alone, 0.99));
  std::filesystem::remove_all(root);
  return 0;
}

}  // namespace firn::bench::loop_latency
