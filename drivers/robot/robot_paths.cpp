#include "drivers/robot/robot_paths.h"

#include <algorithm>
#include <span>

#include "drivers/link/crc16.h"
#include "drivers/robot/robot_tag.h"

namespace firn::drivers {
namespace {

constexpr int kMaxTries = 3;

}  // namespace

const RobotPaths::Kept* RobotPaths::find(std::int64_t path) const {
  const auto at = paths_.find(path);
  return at == paths_.end() ? nullptr : &at->second;
}

void RobotPaths::forget_before(std::int64_t path) {
  paths_.erase(paths_.begin(), paths_.lower_bound(path));
  spent_.erase(spent_.begin(), spent_.lower_bound(PathPart{path, 0, 0}));
}

const RobotPaths::Slot* RobotPaths::slot_of(const PathPart& part) const {
  for (const Slot& s : slots_)
    if (s.id != 0 && s.part == part) return &s;
  return nullptr;
}

bool RobotPaths::holds(const PathPart& part) const {
  return std::any_of(slots_.begin(), slots_.end(),
                     [&](const Slot& s) { return s.id != 0 && s.part == part && s.verified; });
}

bool RobotPaths::in_slot(std::int32_t id) const {
  return std::any_of(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.id == id; });
}

void RobotPaths::let_overwrite(const PathPart& part) {
  for (Slot& s : slots_)
    if (s.id != 0 && s.part == part) {
      s.verified = false;
      return;
    }
}

void RobotPaths::abandon() {
  dialect_.points = {};
  upload_ = {};
}

void RobotPaths::forget_slots() {
  abandon();
  for (Slot& s : slots_) s = {};
}

void RobotPaths::begin(const PathPart& part, const Points& points, Slot& slot) {
  const bool again = slot.id != 0 && slot.part == part;
  const std::int32_t old_id = slot.id;
  const int tries = again ? upload_.tries : 0;
  last_id_ = last_id_ >= fvp::kMaxId ? 1 : last_id_ + 1;
  slot = {last_id_, part, false};
  upload_ = {};
  upload_.slot = &slot;
  upload_.points = points;
  upload_.first = std::size_t(part.from);
  upload_.count = std::size_t(part.to - part.from + 1);
  upload_.tries = tries + 1;
  dialect_.points = std::span(*points).subspan(upload_.first, upload_.count);
  fvp::PointsCrc crc;
  for (const fvp::Counts& p : dialect_.points) crc.add(p);
  upload_.crc = crc.value();
  if (old_id != 0) push(fvp::request(seq(), "PATH DROP").word(old_id), robot_tag::kDropSlot);
  push(fvp::request(seq(), "PATH BEGIN")
           .word(last_id_)
           .text(" N=")
           .number(std::int64_t(upload_.count))
           .text(" DT=0.016"),
       robot_tag::kBegin);
}

bool RobotPaths::choose(const Use& use) {
  const bool wanted = use.wanted && !holds(*use.wanted);
  Slot* free = nullptr;
  for (Slot& s : slots_) {
    if (use.running == s.part && s.id != 0) continue;
    const bool useless = s.id == 0 || !s.verified || !paths_.contains(s.part.path) ||
                         spent_.contains(s.part) || s.part.path < last_path_;
    if (useless || (wanted && !free)) free = &s;
    if (useless) break;
  }
  if (!free) return false;
  if (wanted) {
    begin(*use.wanted, paths_.at(use.wanted->path).points, *free);
    return true;
  }
  if (!use.ahead) return false;
  for (auto at = paths_.upper_bound(last_path_); at != paths_.end(); ++at) {
    const Points& points = at->second.points;
    if (!points || points->size() > std::size_t(fvp::kMaxPoints)) continue;
    const PathPart part{at->first, 0, std::int32_t(points->size()) - 1};
    if (spent_.contains(part)) continue;
    if (slot_of(part)) return false;  // it is there already
    begin(part, points, *free);
    return true;
  }
  return false;
}

bool RobotPaths::step(const Use& use) {
  if (!upload_.slot) return choose(use);
  if (!upload_.begun) return false;  // its reply is still to come
  if (upload_.held < upload_.count) {
    const std::size_t block =
        std::min(upload_.count - upload_.held, std::size_t(use.block_lines * fvp::kPointsPerLine));
    link_.push(fvp::path_block(seq(), upload_.held, block, robot_tag::kPoints));
  } else {
    char crc[4];
    put_hex4(crc, upload_.crc);
    push(fvp::request(seq(), "PATH END").word(std::string_view(crc, 4)), robot_tag::kEnd);
  }
  return true;
}

std::string RobotPaths::acknowledged(std::uint16_t tag, std::int64_t number) {
  if (!upload_.slot) return {};  // given up meanwhile
  switch (tag) {
    case robot_tag::kBegin:
      upload_.begun = true;
      return {};
    case robot_tag::kPoints:
      if (std::size_t(number) > upload_.count) return "more points held than sent";
      if (std::size_t(number) <= upload_.held && ++upload_.tries > kMaxTries) return "no points are kept";
      upload_.held = std::size_t(number);
      return {};
    default:
      upload_.slot->verified = true;
      abandon();
      return {};
  }
}

std::optional<RobotPaths::Refusal> RobotPaths::refused(std::string_view why) {
  if (!upload_.slot) return std::nullopt;
  const Upload was = upload_;
  const PathPart part = was.slot->part;
  if (was.tries < kMaxTries) {
    begin(part, was.points, *was.slot);
    return Refusal{part, false};
  }
  abandon();
  paths_[part.path] = {nullptr, "the robot does not take it: " + std::string(why)};
  return Refusal{part, true};
}

}  // namespace firn::drivers
