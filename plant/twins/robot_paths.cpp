// Loading paths into the two slots.
#include <charconv>

#include "plant/twins/robot.h"

namespace firn::plant {

using namespace drivers::fvp;
using drivers::WordReader;

RobotTwin::Slot* RobotTwin::find(std::int32_t id) {
  for (Slot& slot : slots_)
    if (slot.id == id && id != 0) return &slot;
  return nullptr;
}

std::string RobotTwin::path(WordReader& words, std::int64_t now_us) {
  const std::string_view verb = words.word();
  if (verb == "P") return add_points(words);
  if (verb == "END") {
    const std::string_view text = words.word();
    std::uint16_t crc = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), crc, 16);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size())
      return nak(Nak::kRange, "CRC of four hex digits");
    if (state_.loading < 0) return nak(Nak::kWrongState, "no path is being loaded");
    Slot& slot = slots_[std::size_t(state_.loading)];
    state_.loading = -1;
    PointsCrc sum;
    bool reachable = true;
    for (const Counts& point : slot.points) {
      sum.add(point);
      reachable &= in_range(drivers::fvp::joints_of(point));
    }
    const bool whole = slot.points.size() == slot.wanted;
    if (!whole || sum.value() != crc || !reachable) {
      slot = {};
      if (!whole) return nak(Nak::kRange, "number of points");
      return reachable ? nak(Nak::kBadCrc, "points")
                       : nak(Nak::kJointLimit, "a point is beyond a joint's range");
    }
    slot.verified = 1;
    return "ACK " + std::to_string(slot.points.size());
  }
  const auto id = std::int32_t(words.number(1, kMostId));
  if (!words.good()) return nak(Nak::kRange, "path number");
  if (verb == "DROP") {
    if (state_.motion == Motion::kPath && state_.running == id) return nak(Nak::kWrongState, "running");
    if (Slot* slot = find(id)) {
      if (state_.loading == slot - slots_.data()) state_.loading = -1;
      *slot = {};
    }
    return "ACK";
  }
  if (verb == "RUN") {
    const int mask = int(words.number(0, 7));
    if (!words.good()) return nak(Nak::kRange, "mask 0 to 7");
    return run(id, mask, now_us);
  }
  if (verb != "BEGIN") return nak(Nak::kRange, "unknown verb");
  const std::string_view count = words.word();
  WordReader number(count.starts_with("N=") ? count.substr(2) : count);
  const auto n = std::uint32_t(number.number(2, kMostPoints));
  if (!number.good() || words.word() != "DT=0.016") return nak(Nak::kRange, "N=2..8192 DT=0.016");
  Slot* slot = find(id);
  const auto is_running = [&](const Slot& s) {
    return state_.motion == Motion::kPath && s.id == state_.running;
  };
  if (slot && is_running(*slot)) return nak(Nak::kWrongState, "running");
  if (state_.loading >= 0 && slot != &slots_[std::size_t(state_.loading)]) {
    if (slot) *slot = {};
    slot = &slots_[std::size_t(state_.loading)];  // a path begun and not ended is forgotten
  }
  for (Slot& s : slots_)
    if (!slot && s.id == 0) slot = &s;
  if (!slot) return nak(Nak::kWrongState, "both slots are taken");
  *slot = {id, n, 0, {}};
  slot->points.reserve(n);
  state_.loading = std::int32_t(slot - slots_.data());
  return "ACK " + std::to_string(state_.loading + 1);
}

std::string RobotTwin::add_points(WordReader& words) {
  if (state_.loading < 0) return nak(Nak::kWrongState, "no path is being loaded");
  Slot& slot = slots_[std::size_t(state_.loading)];
  const std::int64_t first = words.number(0, kMostPoints);
  if (words.good() && first == std::int64_t(slot.points.size()))
    for (int n = 0; n < kPointsPerLine && !words.at_end() && slot.points.size() < slot.wanted; ++n) {
      const auto point = parse_counts(words);
      if (!point) break;
      slot.points.push_back(*point);
    }
  return "ACK " + std::to_string(slot.points.size());
}

}  // namespace firn::plant
