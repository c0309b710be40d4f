#include "files/record/event_index.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace firn::record {
namespace {

constexpr std::uint32_t kMaxChannelIds = 1 << 16;  // of a log; a damaged number is no reason to take memory

}  // namespace

std::filesystem::path index_path(const std::filesystem::path& log) { return log.string() + ".idx"; }

EventIndex::EventIndex(std::span<const std::byte> file) {
  RecordReader reader(file);
  bool sorted = true;
  while (const auto record = reader.next()) {
    if (record->damaged) continue;
    const auto payload = record->payload;
    if (record->kind == kIndexChannelRecord && payload.size() > 4) {
      std::uint32_t id;
      std::memcpy(&id, payload.data(), 4);
      channels_.insert_or_assign(
          id, std::string(reinterpret_cast<const char*>(payload.data()) + 4, payload.size() - 4));
    } else if (record->kind == kIndexEntriesRecord) {
      for (std::size_t at = 0; at + sizeof(IndexEntry) <= payload.size(); at += sizeof(IndexEntry)) {
        IndexEntry e;
        std::memcpy(&e, payload.data() + at, sizeof e);
        sorted = sorted && (entries_.empty() || entries_.back().eventnum <= e.eventnum);
        entries_.push_back(e);
      }
    }
  }
  if (!sorted) sort();
  damage_ = reader.damage();
}

// Of an index that was put together of others.
void EventIndex::sort() {
  std::vector<IndexEntry> all;
  for (std::size_t n = 0; n < entries_.size(); ++n) all.push_back(entries_[n]);
  std::ranges::stable_sort(all, {}, &IndexEntry::eventnum);
  entries_ = LongList<IndexEntry>(*blocks_);
  for (const IndexEntry& e : all) entries_.push_back(e);
}

bool each_entry(const MappedFile& file,
                const std::function<bool(const IndexEntry&, std::string_view channel)>& use) {
  RecordReader reader(file.bytes());
  std::vector<std::string> channels;  // by id
  std::uint64_t next = 0;
  while (const auto record = reader.next()) {
    if (record->damaged) return false;
    const auto payload = record->payload;
    std::uint32_t id = 0;
    if (record->kind == kIndexChannelRecord && payload.size() > 4) {
      std::memcpy(&id, payload.data(), 4);
      if (id >= kMaxChannelIds) return false;
      if (id >= channels.size()) channels.resize(id + 1);
      channels[id].assign(reinterpret_cast<const char*>(payload.data()) + 4, payload.size() - 4);
    }
    if (record->kind != kIndexEntriesRecord) continue;
    for (std::size_t at = 0; at + sizeof(IndexEntry) <= payload.size(); at += sizeof(IndexEntry)) {
      IndexEntry e;
      std::memcpy(&e, payload.data() + at, sizeof e);
      if (e.eventnum < next) return false;
      next = e.eventnum + 1;
      if (!use(e, e.channel < channels.size() ? std::string_view(channels[e.channel]) : std::string_view{}))
        return false;
    }
    file.forget_before(record->offset);
  }
  return reader.damage().count() == 0;
}

const IndexEntry* EventIndex::find(std::uint64_t eventnum) const {
  // Numbers count from 0 without gaps unless a block is lost.
  if (eventnum < entries_.size() && entries_[eventnum].eventnum == eventnum) return &entries_[eventnum];
  const std::size_t at = entries_.partition_point([&](const IndexEntry& e) { return e.eventnum < eventnum; });
  return at < entries_.size() && entries_[at].eventnum == eventnum ? &entries_[at] : nullptr;
}

std::string_view EventIndex::channel(std::uint32_t id) const {
  const auto it = channels_.find(id);
  return it == channels_.end() ? std::string_view{} : std::string_view(it->second);
}

EventIndexWriter::EventIndexWriter(const std::filesystem::path& path, RecordWriter::Mode mode)
    : file_(path, mode) {
  if (mode != RecordWriter::Mode::kAppend) return;
  const MappedFile mapped(path);
  RecordReader reader(mapped.bytes());
  while (const auto record = reader.next())
    if (!record->damaged && record->kind == kIndexChannelRecord && record->payload.size() > 4) {
      std::uint32_t id;
      std::memcpy(&id, record->payload.data(), 4);
      ids_[std::string(reinterpret_cast<const char*>(record->payload.data()) + 4,
                       record->payload.size() - 4)] = id;
    }
}

std::uint32_t EventIndexWriter::channel_id(std::string_view name) {
  if (const auto it = ids_.find(name); it != ids_.end()) return it->second;
  std::uint32_t id = 0;
  for (const auto& [_, used] : ids_) id = std::max(id, used + 1);
  ids_.emplace(name, id);
  new_channels_.emplace_back(id, name);
  return id;
}

void EventIndexWriter::append(std::vector<IndexEntry>& entries) {
  while (!new_channels_.empty()) {
    const auto& [id, name] = new_channels_.front();
    const std::array<std::span<const std::byte>, 2> parts{std::as_bytes(std::span(&id, 1)),
                                                          std::as_bytes(std::span(name))};
    file_.append(kIndexChannelRecord, parts);
    new_channels_.erase(new_channels_.begin());
  }
  std::size_t done = 0;
  const auto forget = [&] { entries.erase(entries.begin(), entries.begin() + std::ptrdiff_t(done)); };
  try {
    while (done < entries.size()) {
      const std::size_t n = std::min(kIndexBlockEntries, entries.size() - done);
      file_.append(kIndexEntriesRecord, std::as_bytes(std::span(entries).subspan(done, n)));
      done += n;
    }
  } catch (const FileError&) {
    forget();
    throw;
  }
  forget();
}

}  // namespace firn::record
