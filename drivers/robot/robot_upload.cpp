// Robot: paths go into the controller's slots ahead of time, while another one runs.
#include <algorithm>

#include "drivers/link/crc16.h"
#include "drivers/robot/robot.h"

namespace firn::drivers {
namespace {

constexpr int kMostTries = 3;

}  // namespace

Robot::Slot* Robot::slot_of(const PathPart& part) {
  for (Slot& s : slots_)
    if (s.id != 0 && s.part == part) return &s;
  return nullptr;
}

bool Robot::holds(const PathPart& part) const {
  return std::any_of(slots_.begin(), slots_.end(),
                     [&](const Slot& s) { return s.id != 0 && s.part == part && s.verified; });
}

void Robot::abandon_upload() {
  dialect_.points = {};
  upload_ = {};
}

void Robot::forget_slots() {
  abandon_upload();
  for (Slot& s : slots_) s = {};
}

void Robot::begin_upload(const PathPart& part, const Points& points, Slot& slot) {
  const bool again = slot.id != 0 && slot.part == part;
  const std::int32_t old_id = slot.id;
  const int tries = again ? upload_.tries : 0;
  last_id_ = last_id_ >= fvp::kMostId ? 1 : last_id_ + 1;
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
  if (old_id != 0) push(fvp::request(seq(), "PATH DROP").word(old_id), Repeat::kSetup, kDropSlot);
  push(fvp::request(seq(), "PATH BEGIN")
           .word(last_id_)
           .text(" N=")
           .number(std::int64_t(upload_.count))
           .text(" DT=0.016"),
       Repeat::kSetup, kBegin);
}

// The part that a command waits for; else, while a slot is free, the next path in order.
bool Robot::choose_upload() {
  const bool wanted = phase_ == Phase::kLoading && !holds(part_);
  const bool running = phase_ == Phase::kRunning || (phase_ == Phase::kMoving && op_ == Op::kRun);
  Slot* free = nullptr;
  for (Slot& s : slots_) {
    if (running && s.part == part_ && s.id != 0) continue;
    const bool useless = s.id == 0 || !s.verified || !paths_.contains(s.part.path) ||
                         spent_.contains(s.part) || s.part.path < last_path_;
    if (useless || (wanted && !free)) free = &s;
    if (useless) break;
  }
  if (!free) return false;
  if (wanted) {
    begin_upload(part_, paths_.at(part_.path).points, *free);
    return true;
  }
  if (!config_.upload_ahead) return false;
  for (auto at = paths_.upper_bound(last_path_); at != paths_.end(); ++at) {
    const Points& points = at->second.points;
    if (!points || points->size() > std::size_t(fvp::kMostPoints)) continue;
    const PathPart part{at->first, 0, std::int32_t(points->size()) - 1};
    if (spent_.contains(part)) continue;
    if (slot_of(part)) return false;  // it is there already
    begin_upload(part, points, *free);
    return true;
  }
  return false;
}

bool Robot::upload_step() {
  if (!upload_.slot) return choose_upload();
  if (!upload_.begun) return false;  // its reply is still to come
  if (upload_.held < upload_.count) {
    const std::size_t block =
        std::min(upload_.count - upload_.held, std::size_t(config_.block_lines * fvp::kPointsPerLine));
    link_.push(fvp::path_block(seq(), upload_.held, block, kPoints));
  } else {
    char crc[4];
    put_hex4(crc, upload_.crc);
    push(fvp::request(seq(), "PATH END").word(std::string_view(crc, 4)), Repeat::kSetup, kEnd);
  }
  return true;
}

void Robot::uploaded(const Request& request, std::int64_t number, Effects& fx) {
  if (!upload_.slot) return;  // given up meanwhile
  switch (request.tag) {
    case kBegin:
      upload_.begun = true;
      return;
    case kPoints:
      if (std::size_t(number) > upload_.count) return upload_refused("more points held than sent", fx);
      if (std::size_t(number) <= upload_.held && ++upload_.tries > kMostTries)
        return upload_refused("no points are kept", fx);
      upload_.held = std::size_t(number);
      return;
    default:
      upload_.slot->verified = true;
      abandon_upload();
  }
}

void Robot::upload_refused(std::string_view why, Effects& fx) {
  if (!upload_.slot) return;
  const Upload was = upload_;
  const bool wanted = phase_ == Phase::kLoading && was.slot->part == part_;
  if (was.tries < kMostTries) {
    fault(0, kCommandRejected,
          "robot: path " + std::to_string(was.slot->part.path) + " again: " + std::string(why), fx);
    return begin_upload(PathPart(was.slot->part), was.points, *was.slot);
  }
  fault(1, kCommandRejected,
        "robot: path " + std::to_string(was.slot->part.path) + " does not load: " + std::string(why), fx);
  const std::int64_t path = was.slot->part.path;
  abandon_upload();
  paths_[path] = {nullptr, "the robot does not take it: " + std::string(why)};
  if (!wanted) return;
  finish({Outcome::kNone, -1, 0, 0, 0, kCommandRejected, std::string(why)}, fx);
  ready("path not loaded", fx);
}

}  // namespace firn::drivers
