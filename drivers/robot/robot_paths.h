// RobotPaths holds the trajectories kept for the robot and the contents of its slots, and uploads the next
// ones ahead of time.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/grid/figure.h"
#include "drivers/link/link.h"
#include "drivers/robot/fvp.h"

namespace firn::drivers {

/// A trajectory, or samples [from, to] of one: it rests at both ends.
struct PathPart {
  std::int64_t path = 0;
  std::int32_t from = 0;
  std::int32_t to = 0;  ///< 0 = the last one
  auto operator<=>(const PathPart&) const = default;
};

class RobotPaths {
 public:
  using Points = std::shared_ptr<const std::vector<fvp::Counts>>;
  struct Kept {
    Points points;
    Violation refusal;  ///< not empty: never to be run
  };
  struct Slot {
    std::int32_t id = 0;  ///< number on the wire; 0 = free
    PathPart part;
    bool verified = false;
  };

  /// @param dialect writes the points of the upload in progress
  /// @param seq number of the last request of the link
  RobotPaths(fvp::FvpDialect& dialect, Link& link, std::int64_t& seq)
      : dialect_(dialect), link_(link), seq_(seq) {}

  /// Keeps a path; a known number is left as it is.
  void keep(std::int64_t path, Kept kept) { paths_.emplace(path, std::move(kept)); }
  const Kept* find(std::int64_t path) const;
  void drop(std::int64_t path) { paths_.erase(path); }  ///< its slot is freed when another path needs it
  /// Paths are printed in the order of their numbers: all paths before one that deposits are over.
  void forget_before(std::int64_t path);
  std::size_t size() const { return paths_.size(); }
  /// Run or loaded last: those behind it are uploaded ahead.
  void set_last(std::int64_t path) { last_path_ = path; }

  /// A part that was started with a valve's signal, never to be started again.
  void spend(const PathPart& part) { spent_.insert(part); }
  void unspend(const PathPart& part) { spent_.erase(part); }
  bool spent(const PathPart& part) const { return spent_.contains(part); }

  const Slot* slot_of(const PathPart& part) const;
  bool holds(const PathPart& part) const;  ///< verified
  bool in_slot(std::int32_t id) const;
  void let_overwrite(const PathPart& part);  ///< its slot may take another one
  void forget_slots();                       ///< the robot has lost them

  /// Who uses slots now.
  struct Use {
    std::optional<PathPart> wanted;   ///< a command waits for it
    std::optional<PathPart> running;  ///< its slot is not to be touched
    bool ahead = true;                ///< other paths may be uploaded
    int block_lines = 1;              ///< path lines sent without waiting for an answer
  };
  /// Queues the next request of an upload, of the part that a command waits for, else of the next path in
  /// order while a slot is free. @returns true if something was queued.
  bool step(const Use& use);
  /// Gives up the upload in progress.
  void abandon();
  /// A good reply to a request of the upload. @returns why the upload must begin again; empty: it goes on.
  std::string acknowledged(std::uint16_t tag, std::int64_t number);
  struct Refusal {
    PathPart part;
    bool given_up = false;  ///< after three times: the path is never to be run
  };
  /// Begins a refused upload again, or gives it up; nothing: there is none.
  std::optional<Refusal> refused(std::string_view why);

 private:
  struct Upload {
    Slot* slot = nullptr;  // null = none
    Points points;         // the dialect writes from them
    std::size_t first = 0, count = 0;
    std::size_t held = 0;  // that the robot confirmed
    std::uint16_t crc = 0;
    bool begun = false;
    int tries = 0;
  };

  bool choose(const Use& use);
  void begin(const PathPart& part, const Points& points, Slot& slot);
  std::int64_t seq() { return seq_ = fvp::next_seq(seq_); }
  void push(LineWriter line, std::uint16_t tag) {
    link_.push(fvp::to_request(line, seq_, Repeat::kSetup, tag));
  }

  fvp::FvpDialect& dialect_;
  Link& link_;
  std::int64_t& seq_;
  std::map<std::int64_t, Kept> paths_;
  std::set<PathPart> spent_;
  std::array<Slot, fvp::kSlots> slots_;
  Upload upload_;
  std::int32_t last_id_ = 0;
  std::int64_t last_path_ = 0;
};

}  // namespace firn::drivers
