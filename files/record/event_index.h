// EventIndex holds the offset and checksum of each event of log.lcm, from log.lcm.idx. The index is a record
// file (record_file.h): blocks with their own checksums, only ever appended to, usable when cut. Format:
// docs/formats.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "files/record/record_file.h"
#include "files/record/spill.h"

namespace firn::record {

inline constexpr std::uint16_t kIndexChannelRecord = 1;  ///< u32 id, then the name
inline constexpr std::uint16_t kIndexEntriesRecord = 2;  ///< IndexEntry after IndexEntry
inline constexpr std::size_t kIndexBlockEntries = 512;   ///< maximum per record: the loss by one flipped bit

struct IndexEntry {
  std::uint64_t eventnum = 0;
  std::uint64_t offset = 0;
  std::int64_t utime_us = 0;
  std::uint64_t checksum = 0;  ///< XXH64 of the event's bytes from its sync word
  std::uint32_t bytes = 0;     ///< of the whole event
  std::uint32_t channel = 0;
};
static_assert(sizeof(IndexEntry) == 40);

/// "<log>.idx"
std::filesystem::path index_path(const std::filesystem::path& log);

/// The index of a log; the memory does not grow with it (spill.h). Of one thread at a time.
class EventIndex {
 public:
  EventIndex() = default;
  /// Accepts any bytes; damaged blocks are omitted (see damage()).
  explicit EventIndex(std::span<const std::byte> index_file);

  /// @returns an entry that is valid until the next call; nullptr if the index does not contain the event.
  const IndexEntry* find(std::uint64_t eventnum) const;
  /// @returns an empty view for an unknown id.
  std::string_view channel(std::uint32_t id) const;
  const LongList<IndexEntry>& entries() const { return entries_; }  ///< by increasing eventnum
  const DamageList& damage() const { return damage_; }

 private:
  void sort();

  std::unique_ptr<Spill> blocks_ = std::make_unique<Spill>(LongList<IndexEntry>::kBlock_bytes);
  LongList<IndexEntry> entries_{*blocks_};
  std::unordered_map<std::uint32_t, std::string> channels_;
  DamageList damage_;
};

/// Hands over the entries of an index file one after the other, with the names of their channels; the memory
/// does not grow with the file. @param use returns false to end it
/// @returns false: a block is damaged, the numbers of the events do not increase, or `use` ended it
bool each_entry(const MappedFile& index_file,
                const std::function<bool(const IndexEntry&, std::string_view channel)>& use);

/// Appends to an index file.
class EventIndexWriter {
 public:
  EventIndexWriter(const std::filesystem::path& path, RecordWriter::Mode mode);  ///< @throws FileError
  /// Returns the id of a channel; the next append() writes a new channel.
  std::uint32_t channel_id(std::string_view name);
  /// Writes new channels, then entries from the front of `entries`; removes the written ones, also when
  /// append() throws FileError.
  void append(std::vector<IndexEntry>& entries);
  void sync() { file_.sync(); }
  void close() { file_.close(); }

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view s) const { return std::hash<std::string_view>{}(s); }
  };
  RecordWriter file_;
  std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> ids_;
  std::vector<std::pair<std::uint32_t, std::string>> new_channels_;
};

}  // namespace firn::record
