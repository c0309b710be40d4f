#include "replay/decision_compare.h"

#include <algorithm>

#include "firn/control_surface_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/channels.h"

namespace firn::replay {
namespace {

template <class Message>
bool decode(std::span<const std::byte> bytes, Message& m) {
  return m.decode(bytes.data(), 0, int(bytes.size())) >= 0;
}

template <class Values>
std::uint64_t differing(const Values& a, const Values& b) {
  std::uint64_t n = std::max(a.size(), b.size()) - std::min(a.size(), b.size());
  for (std::size_t c = 0; c < std::min(a.size(), b.size()); ++c) n += a[c] != b[c];
  return n;
}

}  // namespace

std::optional<std::uint64_t> differing_cells(std::string_view channel, std::span<const std::byte> a,
                                             std::span<const std::byte> b) {
  const bool same = std::ranges::equal(a, b);
  if (channel == channels::kLayerPlan.name) {
    layer_plan_t x, y;
    if (same) return 0;
    if (!decode(a, x)) return std::nullopt;
    if (!decode(b, y)) return x.drops.size();
    if (x.drops.size() != y.drops.size()) return differing(x.drops, y.drops);
    std::uint64_t n = 0;  // a cell may differ in droplets, ink, place, or more of these
    const bool inks = x.material.size() == y.material.size();
    const auto place = [](const layer_plan_t& p, std::size_t c) {
      return c < p.offset.size() ? p.offset[c] : 0;
    };
    for (std::size_t c = 0; c < x.drops.size(); ++c)
      n += x.drops[c] != y.drops[c] ||
           (x.drops[c] != 0 && ((inks && c < x.material.size() && x.material[c] != y.material[c]) ||
                                place(x, c) != place(y, c)));
    return n;
  }
  if (channel == channels::kControlSurface.name) {
    control_surface_t x, y;
    if (same) return 0;
    if (!decode(a, x)) return std::nullopt;
    if (!decode(b, y)) return x.u.size();
    return x.decision == y.decision ? differing(x.u, y.u) : std::uint64_t(std::max(x.u.size(), y.u.size()));
  }
  return std::nullopt;
}

}  // namespace firn::replay
