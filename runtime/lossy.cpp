#include "runtime/lossy.h"

#include <limits>
#include <sstream>
#include <stdexcept>

namespace firn {
namespace {

constexpr double kReorderUs = 4000.0;  // longest time that a reordered datagram is overtaken

}  // namespace

std::string to_text(const LossyCounts& c) {
  return "passed " + std::to_string(c.passed) + " lost " + std::to_string(c.lost) + " duplicated " +
         std::to_string(c.duplicated) + " reordered " + std::to_string(c.reordered) + " delayed " +
         std::to_string(c.delayed) + "\n";
}

LossyCounts parse_lossy_counts(std::string_view text) {
  std::istringstream in{std::string(text)};
  LossyCounts c;
  std::string passed, lost, duplicated, reordered, delayed;
  in >> passed >> c.passed >> lost >> c.lost >> duplicated >> c.duplicated >> reordered >> c.reordered >>
      delayed >> c.delayed;
  if (!in || passed != "passed" || lost != "lost" || duplicated != "duplicated" || reordered != "reordered" ||
      delayed != "delayed")
    throw std::runtime_error("not a line of fault counts: '" + std::string(text.substr(0, 100)) + "'");
  return c;
}

Lossy::Lossy(const LossyOptions& options)
    : options_(options), random_(options.seed, Purpose::kBusFault, options.node, options.incarnation) {}

void Lossy::receive(std::string_view channel, std::span<const std::byte> datagram, std::int64_t wall_us,
                    const Sink& sink) {
  if (random_.uniform() < options_.loss) {
    ++counts_.lost;
    return;
  }
  ++counts_.passed;
  if (random_.uniform() < options_.duplicate) {
    ++counts_.duplicated;
    keep(channel, datagram, wall_us + std::int64_t(random_.uniform() * kReorderUs));
  }
  if (random_.uniform() < options_.delay) {
    ++counts_.delayed;
    keep(channel, datagram, wall_us + std::int64_t(2e6 * options_.delay_s * random_.uniform()));
  } else if (random_.uniform() < options_.reorder) {
    ++counts_.reordered;
    keep(channel, datagram, wall_us + 1 + std::int64_t(random_.uniform() * kReorderUs));
  } else {
    sink(channel, datagram);
  }
}

void Lossy::keep(std::string_view channel, std::span<const std::byte> datagram, std::int64_t until_us) {
  kept_.emplace(until_us, Kept{std::string(channel), {datagram.begin(), datagram.end()}});
}

void Lossy::release(std::int64_t wall_us, const Sink& sink) {
  while (!kept_.empty() && kept_.begin()->first <= wall_us) {
    const auto node = kept_.extract(kept_.begin());
    sink(node.mapped().channel, node.mapped().bytes);
  }
}

std::int64_t Lossy::due_us() const {
  return kept_.empty() ? std::numeric_limits<std::int64_t>::max() : kept_.begin()->first;
}

}  // namespace firn
