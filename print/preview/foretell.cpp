#include "print/preview/foretell.h"

#include <ctime>
#include <exception>

#include "firn/layer_metrics_t.hpp"
#include "lcmtypes/channels.h"
#include "print/simulated/memory_print.h"

namespace firn {
namespace {

struct TooLong {};

double thread_cpu_s() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + double(t.tv_nsec) * 1e-9;
}

}  // namespace

std::optional<Foretold> foretell(const Product& product, const Experiment& e, const Blobs& inputs,
                                 double within_s) {
  constexpr double kUs = 1e-6;
  const double until_s = thread_cpu_s() + within_s;
  Foretold f;
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    if (thread_cpu_s() > until_s) throw TooLong{};
    layer_metrics_t m{};
    if (channel != channels::kLayerMetrics.name || m.decode(bytes.data(), 0, int(bytes.size())) < 0) return;
    f.layer_s[m.layer] = double(m.header.utime_us) * kUs;
    f.amount = m.drops_total;
  };
  try {
    const MemoryPrintReport report = print_in_memory(product, e, inputs, options);
    if (report.result.status != 0) return std::nullopt;
    f.time_s = report.node_s;
  } catch (const TooLong&) {
    return std::nullopt;
  } catch (const std::exception&) {  // the print names it
    return std::nullopt;
  }
  return f;
}

}  // namespace firn
