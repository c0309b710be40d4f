#include <sys/uio.h>

#include "files/record/checksum.h"
#include "files/record/event_log.h"

namespace firn::record {
namespace {

constexpr std::size_t kMaxChannelBytes = 63;  // LCM's limit for sending

}  // namespace

EventLogWriter::EventLogWriter(const std::filesystem::path& path, const Options& options)
    : log_(path, options.mode), options_(options) {
  buffer_.reserve(options.flush_bytes + options.flush_bytes / 4);
  if (log_.position() > 0)
    continue_log();
  else
    std::filesystem::remove(index_path(path));  // of a log that is gone
  if (!index_) index_.emplace(index_path(path), RecordWriter::Mode::kAppend);
}

// Finds the end of the last whole event, saves the bytes behind that end, and makes the index agree with the
// log.
void EventLogWriter::continue_log() {
  const EventLogFile old(path());
  EventLogReader reader = old.reader();
  std::vector<IndexEntry> entries;
  std::vector<std::string_view> channels;
  bool agrees = old.has_index() && old.index().damage().count() == 0 && !reader.index_ignored();
  while (const auto event = reader.next()) {
    const IndexEntry* known = reader.index_ignored() ? nullptr : old.index().find(event->eventnum);
    agrees = agrees && known && known->offset == event->offset;
    IndexEntry entry{event->eventnum, event->offset, event->utime_us, 0, 0, 0};
    entry.bytes = std::uint32_t(kEventHeaderBytes + event->channel.size() + event->data.size());
    // A damaged event keeps the checksum that reveals the damage.
    entry.checksum = known ? known->checksum : checksum64(old.bytes().subspan(event->offset, entry.bytes));
    entries.push_back(entry);
    channels.push_back(event->channel);
  }
  const std::uint64_t end = reader.valid_end();
  const std::size_t start = std::min(old.bytes().size(), kEventSyncBytes.size());
  if (end == 0 && std::memcmp(old.bytes().data(), kEventSyncBytes.data(), start) != 0)
    throw std::runtime_error(path().string() + ": byte 0: not an LCM log");
  next_eventnum_ = reader.valid_next_eventnum();
  while (!entries.empty() && entries.back().offset >= end) entries.pop_back();
  agrees = agrees && old.index().entries().size() == entries.size();
  if (!agrees) {
    const std::filesystem::path fresh = index_path(path()).string() + ".new";
    std::filesystem::remove(fresh);
    index_.emplace(fresh, RecordWriter::Mode::kCreate);
    for (std::size_t i = 0; i < entries.size(); ++i) entries[i].channel = index_->channel_id(channels[i]);
    index_->append(entries);
    index_->sync();
    index_.reset();
    std::filesystem::rename(fresh, index_path(path()));
  }
  if (end < old.bytes().size()) {
    torn_path_ = save_torn_tail(path(), old.bytes().subspan(end));
    log_.truncate(end);
  }
}

void EventLogWriter::append(std::int64_t utime_us, std::string_view channel,
                            std::span<const std::byte> data) {
  if (channel.size() > kMaxChannelBytes || !plausible_channel(channel))
    throw std::invalid_argument(path().string() + ": channel '" + std::string(channel.substr(0, 80)) +
                                "' is not 1 to 63 printable bytes");
  if (data.size() > 0x7fffffffu)
    throw std::invalid_argument(path().string() + ": channel " + std::string(channel) + ": " +
                                std::to_string(data.size()) +
                                " bytes of data, an event holds at most 2147483647");
  const EventHeader header{log_.position() + buffer_.size(), next_eventnum_, utime_us,
                           std::int32_t(channel.size()), std::int32_t(data.size())};
  if (!buffer_.empty() && buffer_.size() + header.bytes() > options_.max_pending_bytes) {
    try {
      flush();
    } catch (const FileError&) {
      ++dropped_;
      throw;
    }
    append(utime_us, channel, data);
    return;
  }
  const std::uint32_t id = index_->channel_id(channel);
  const std::size_t before = buffer_.size();
  std::array<std::byte, kEventHeaderBytes> head;
  put_event_header(head.data(), header);
  const auto name = std::as_bytes(std::span(channel));
  buffer_.insert(buffer_.end(), head.begin(), head.end());
  buffer_.insert(buffer_.end(), name.begin(), name.end());
  buffer_.insert(buffer_.end(), data.begin(), data.end());
  pending_.push_back({next_eventnum_++, header.at, utime_us, checksum64(std::span(buffer_).subspan(before)),
                      std::uint32_t(header.bytes()), id});
  if (buffer_.size() >= options_.flush_bytes) flush();
}

void EventLogWriter::flush() {
  if (!buffer_.empty()) {
    const std::uint64_t start = log_.position();
    iovec all{buffer_.data(), buffer_.size()};
    try {
      log_.write({&all, 1});
    } catch (const FileError&) {
      // Keep the whole events that fitted, take back the half one, remember the rest.
      std::size_t whole = 0;
      while (whole < pending_.size() && pending_[whole].offset + pending_[whole].bytes <= log_.position())
        ++whole;
      const std::uint64_t end = whole < pending_.size() ? pending_[whole].offset : log_.position();
      if (log_.position() != end) log_.truncate(end);
      buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(end - start));
      written_.insert(written_.end(), pending_.begin(), pending_.begin() + std::ptrdiff_t(whole));
      pending_.erase(pending_.begin(), pending_.begin() + std::ptrdiff_t(whole));
      throw;
    }
    buffer_.clear();
    written_.insert(written_.end(), pending_.begin(), pending_.end());
    pending_.clear();
  }
  index_->append(written_);
}

void EventLogWriter::sync() {
  flush();
  log_.sync();
  index_->sync();
}

void EventLogWriter::close() {
  flush();
  index_->close();
  log_.close();
}

}  // namespace firn::record
