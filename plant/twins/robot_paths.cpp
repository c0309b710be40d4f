// Loading paths into the two slots.

#include "core/options/number.h"
#include "plant/twins/arm_controller.h"
#include "plant/twins/robot.h"

namespace firn::plant {

using namespace fvp;

RobotTwin::Slot* RobotTwin::find(std::int32_t id) {
  for (Slot& slot : slots_)
    if (slot.id == id && id != 0) return &slot;
  return nullptr;
}

std::string RobotTwin::path(Words& words, std::int64_t now_us) {
  const std::string_view verb = words.next();
  if (verb == "P") return add_points(words);
  if (verb == "END") {
    const std::optional<std::uint16_t> crc = whole_hex_number<std::uint16_t>(words.next());
    if (!crc) return refused(Nak::kRange, "CRC of four hex digits");
    if (state_.loading < 0) return refused(Nak::kState, "no path is being loaded");
    Slot& slot = slots_[std::size_t(state_.loading)];
    state_.loading = -1;
    bool reachable = true;
    for (const Point& point : slot.points) reachable &= in_range(params_, joints_at(point));
    const bool whole = slot.points.size() == slot.wanted;
    if (!whole || checksum(slot.points) != *crc || !reachable) {
      slot = {};
      if (!whole) return refused(Nak::kRange, "number of points");
      return reachable ? refused(Nak::kChecksum, "points")
                       : refused(Nak::kJointLimit, "a point is beyond a joint's range");
    }
    slot.verified = 1;
    return "ACK " + std::to_string(slot.points.size());
  }
  const auto id = std::int32_t(words.integer(1, kMaxPath));
  if (!words.good()) return refused(Nak::kRange, "path number");
  if (verb == "DROP") {
    if (state_.motion == Motion::kPath && state_.running == id) return refused(Nak::kState, "running");
    if (Slot* slot = find(id)) {
      if (state_.loading == slot - slots_.data()) state_.loading = -1;
      *slot = {};
    }
    return "ACK";
  }
  if (verb == "RUN") {
    const int mask = int(words.integer(0, 7));
    if (!words.good()) return refused(Nak::kRange, "mask 0 to 7");
    return run(id, mask, now_us);
  }
  if (verb != "BEGIN") return refused(Nak::kRange, "unknown verb");
  const std::string_view count = words.next();
  Words number(count.starts_with("N=") ? count.substr(2) : count);
  const auto n = std::uint32_t(number.integer(kFewestPoints, kMaxPoints));
  if (!number.good() || words.next() != "DT=0.016") return refused(Nak::kRange, "N=2..8192 DT=0.016");
  Slot* slot = find(id);
  const auto is_running = [&](const Slot& s) {
    return state_.motion == Motion::kPath && s.id == state_.running;
  };
  if (slot && is_running(*slot)) return refused(Nak::kState, "running");
  if (state_.loading >= 0 && slot != &slots_[std::size_t(state_.loading)]) {
    if (slot) *slot = {};
    slot = &slots_[std::size_t(state_.loading)];  // a path begun and not ended is forgotten
  }
  for (Slot& s : slots_)
    if (!slot && s.id == 0) slot = &s;
  if (!slot) return refused(Nak::kState, "both slots are taken");
  *slot = {id, n, 0, {}};
  slot->points.reserve(n);
  state_.loading = std::int32_t(slot - slots_.data());
  return "ACK " + std::to_string(state_.loading + 1);
}

std::string RobotTwin::add_points(Words& words) {
  if (state_.loading < 0) return refused(Nak::kState, "no path is being loaded");
  Slot& slot = slots_[std::size_t(state_.loading)];
  const std::int64_t first = words.integer(0, kMaxPoints);
  if (words.good() && first == std::int64_t(slot.points.size()))
    for (std::size_t n = 0; n < kPointsALine && words.more() && slot.points.size() < slot.wanted; ++n) {
      const auto point = next_point(words);
      if (!point) break;
      slot.points.push_back(*point);
    }
  return "ACK " + std::to_string(slot.points.size());
}

}  // namespace firn::plant
