// RecordedLog reads the messages of a run that is over from log.lcm alone, which holds them all once: a tenth
// of the bytes of the write-ahead files.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "files/record/event_index.h"
#include "files/record/file.h"
#include "lcmtypes/channels.h"
#include "page/record_tail.h"

namespace firn::page {

class RecordedLog {
 public:
  /// Returns the log of a run that has ended; nothing if the log cannot stand for the write-ahead files: it
  /// or its index is missing, an event is damaged, the last incarnation has no end, or the numbers of a
  /// reliable channel have a gap.
  /// @param wanted channels; others are passed over
  static std::unique_ptr<RecordedLog> open(const std::filesystem::path& run,
                                           const std::set<std::string, std::less<>>& wanted);

  /// Hands over the messages in order of their time; of one node in its order.
  void each(const RecordTail::Sink& sink) const;

  /// Returns the configuration that the nodes began with; empty: the log holds none.
  std::string config() const;

  /// Returns a message of today's type.
  std::vector<std::byte> read(const Place& place) const;

 private:
  struct Found {
    std::int64_t utime_us = 0;
    NodeId publisher{};
    std::string_view channel;
    std::span<const std::byte> message;
  };
  explicit RecordedLog(const std::filesystem::path& log);
  std::optional<std::span<const std::byte>> message(const logfile::IndexEntry& entry) const;
  bool find(const std::set<std::string, std::less<>>& wanted);

  logfile::MappedFile log_;
  logfile::EventIndex index_;
  replay::RunMigration migration_;
  std::vector<Found> found_;
};

}  // namespace firn::page
