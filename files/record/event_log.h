// EventLogWriter and EventLogReader write and read LCM event logs that survive damage: the writer writes
// large pieces with an index of checksums beside the log, the reader continues behind any damage. The files
// are valid for lcm-logplayer. Both are independent of the types of messages. Format: docs/formats.md.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "files/record/damage.h"
#include "files/record/event_format.h"
#include "files/record/event_index.h"
#include "files/record/file.h"

namespace firn::record {

/// Writes `path` and `path`.idx. Events are buffered and written in one write of at least flush_bytes, or on
/// flush(). The index never lists an event that is not whole in the log.
class EventLogWriter {
 public:
  using Mode = File::Mode;
  struct Options {
    Mode mode = Mode::kCreate;
    std::size_t flush_bytes = std::size_t(1) << 20;
    std::size_t max_pending_bytes = std::size_t(256) << 20;  ///< kept while the disk refuses writes
  };
  /// kAppend continues behind the last whole event; a torn one is first copied to "<path>.torn-<n>"; an index
  /// that lags, is damaged or is missing is rewritten. @throws FileError, std::runtime_error (not an LCM log)
  EventLogWriter(const std::filesystem::path& path, const Options& options);
  explicit EventLogWriter(const std::filesystem::path& path) : EventLogWriter(path, Options{}) {}

  /// @param utime_us time stamp of the event. @param channel 1 to 63 printable bytes. @param data below 2^31
  /// bytes
  /// @throws FileError when the buffer was full and could not be written. The event is kept (see
  /// pending_bytes)
  ///         unless max_pending_bytes would be exceeded; append() and flush() may be tried again.
  ///         std::invalid_argument for a channel or data that the format cannot hold.
  void append(std::int64_t utime_us, std::string_view channel, std::span<const std::byte> data);
  /// Writes the pending events. @throws FileError: whole events that were written are in log and index, the
  /// rest is pending.
  void flush();
  void sync();   ///< flush(), then fdatasync of log and index. @throws FileError
  void close();  ///< flush(), then close. The destructor alone drops pending events. @throws FileError

  std::uint64_t events() const { return next_eventnum_; }  ///< number of the next event
  std::size_t pending_bytes() const { return buffer_.size(); }
  std::size_t pending_events() const { return pending_.size(); }
  std::uint64_t dropped_events() const { return dropped_; }  ///< refused: max_pending_bytes
  std::uint64_t bytes() const { return log_.position(); }    ///< written so far
  const std::filesystem::path& path() const { return log_.path(); }
  const std::filesystem::path& torn_path() const { return torn_path_; }

 private:
  void continue_log();

  File log_;
  Options options_;
  std::optional<EventIndexWriter> index_;
  std::vector<std::byte> buffer_;    // whole events, not yet in the log
  std::vector<IndexEntry> pending_;  // of the events in buffer_
  std::vector<IndexEntry> written_;  // in the log, not yet in the index
  std::uint64_t next_eventnum_ = 0;
  std::uint64_t dropped_ = 0;
  std::filesystem::path torn_path_;
};

struct Event {
  std::uint64_t eventnum = 0;
  std::int64_t utime_us = 0;
  std::string_view channel;
  std::span<const std::byte> data;
  std::uint64_t offset = 0;  ///< of the sync word in the log
  bool damaged = false;      ///< part of the event is known to be wrong
  bool checked = false;      ///< the checksum of the index holds
};

/// Reads events from the bytes of a log (see MappedFile). Accepts any bytes: never crashes, linear time;
/// allocates the damage list and, once something is missing, 32 bytes per event. With an index, flipped
/// payload bits are found and damaged headers are restored. In a log whose numbers do not count (Java's
/// lcm.logging.Log writes what the caller sets, mostly 0) only sync words and lengths tell events apart: then
/// events are numbered here, and none is dropped as a repeated one.
class EventLogReader {
 public:
  /// @param index of this log, or nullptr; must outlive the reader. An index that belongs to another log is
  /// ignored.
  explicit EventLogReader(std::span<const std::byte> log, const EventIndex* index = nullptr);

  /// Returns the next event, or nothing at the end. After damage the reader continues at the next credible
  /// event; repeated events are dropped. damage() lists each of these.
  std::optional<Event> next();
  const DamageList& damage() const { return damage_; }
  bool index_ignored() const { return index_ignored_; }
  bool numbered() const { return numbered_; }           ///< the event numbers of the log count
  std::uint64_t restarts() const { return restarts_; }  ///< times that another log began: `cat a b`
  /// Return the byte behind the last undamaged event returned so far, and the event number that follows.
  std::uint64_t valid_end() const { return valid_end_; }
  std::uint64_t valid_next_eventnum() const { return valid_next_; }

 private:
  bool may_spend(std::uint64_t bytes) const { return bytes <= 1024 || spent_in_vain_ <= 4 * log_.size(); }
  bool index_belongs() const;
  bool numbers_count() const;
  std::optional<Event> next_unnumbered();
  bool certain(const EventHeader& h);
  bool successor_follows(const EventHeader& h) const;
  bool sync_follows(const EventHeader& h) const;
  bool swallows_events(const EventHeader& h);
  bool credible_in_place(const EventHeader& h);
  bool credible_after_damage(const EventHeader& h);
  std::optional<Event> restored_by_index();
  std::uint64_t find_credible(std::uint64_t from);
  std::optional<Event> in_place();
  void skip_damage();
  bool is_stray(std::uint64_t eventnum, std::uint64_t at);
  bool starts_anew(const EventHeader& h) const;
  Event accept(const EventHeader& h, std::uint64_t eventnum, bool damaged, bool checked);

  std::span<const std::byte> log_;
  const EventIndex* index_;
  std::uint64_t at_ = 0;
  std::uint64_t expected_ = 0;  // number of the next event
  std::int64_t shift_ = 0;      // place in the file - place in the index, of the last certain event
  std::uint64_t valid_end_ = 0;
  std::uint64_t valid_next_ = 0;
  std::uint64_t spent_in_vain_ = 0;
  std::optional<EventHeader> first_;
  std::uint64_t restarts_ = 0;
  bool index_ignored_ = false;
  bool numbered_ = true;
  DamageList damage_;
  SequenceMap places_;
};

/// A log with the index beside it, mapped.
class EventLogFile {
 public:
  explicit EventLogFile(const std::filesystem::path& path);  ///< @throws FileError; the index is optional
  EventLogReader reader() const { return EventLogReader(log_.bytes(), has_index_ ? &index_ : nullptr); }
  std::span<const std::byte> bytes() const { return log_.bytes(); }
  /// Gives the memory of bytes before `offset` back, as they are read in order.
  void forget_before(std::uint64_t offset) const { log_.forget_before(offset); }
  bool has_index() const { return has_index_; }
  const EventIndex& index() const { return index_; }

 private:
  MappedFile log_;
  EventIndex index_;
  bool has_index_ = false;
};

}  // namespace firn::record
