#include "cli/log_repair.h"

#include <algorithm>
#include <deque>

#include "lcmtypes/channels.h"
#include "logfile/record_file.h"
#include "runtime/transport_wire.h"
#include "runtime/write_ahead.h"

namespace firn {
namespace {

using logfile::MessageSource;
using logfile::SourceMessage;

// The messages that the nodes put out, file after file.
class WriteAheadSource {
 public:
  explicit WriteAheadSource(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".wal") paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const auto& path : paths) files_.emplace_back(path);
  }

  std::optional<SourceMessage> next() {
    while (true) {
      for (; output_ < outputs_.size(); ++output_)
        if (auto m = message(outputs_[output_])) {
          ++output_;
          return m;
        }
      if (!next_outputs()) return {};
    }
  }

 private:
  static std::optional<SourceMessage> message(const Output& o) {
    if (o.kind != OutputKind::kSend) return {};
    const ChannelInfo* channel = find_channel(o.channel);
    const auto header = wire::read_header(o.bytes);
    if (!channel || !channel->logged || channel->delivery != Delivery::kReliable || !header) return {};
    return SourceMessage{header->utime_us, channel->name, *message_key(o.channel, o.bytes), o.bytes};
  }

  // Takes the outputs of the next whole record that has some; damaged ones and what cannot be decoded are left alone.
  bool next_outputs() {
    outputs_.clear();
    output_ = 0;
    while (true) {
      if (!reader_) {
        if (file_ == files_.size()) return false;
        reader_.emplace(files_[file_++].bytes());
      }
      const auto record = reader_->next();
      if (!record) {
        reader_.reset();
        continue;
      }
      if (record->damaged || WalKind(record->kind) != WalKind::kOutputs) continue;
      try {
        outputs_ = decode_output_list(decode_outputs(record->payload).body);
        return true;
      } catch (const std::runtime_error&) {
        continue;
      }
    }
  }

  std::deque<logfile::MappedFile> files_;
  std::size_t file_ = 0;
  std::optional<logfile::RecordReader> reader_;
  std::vector<Output> outputs_;
  std::size_t output_ = 0;
};

}  // namespace

std::optional<logfile::MessageKey> message_key(std::string_view channel, std::span<const std::byte> message) {
  if (!find_channel(channel)) return {};
  const auto header = wire::read_header(message);
  if (!header) return {};
  return logfile::MessageKey{std::uint64_t(header->incarnation), std::uint64_t(header->seq)};
}

logfile::RepairReport repair_from_write_ahead(const std::filesystem::path& log, const std::filesystem::path& wal_folder) {
  WriteAheadSource source(wal_folder);
  return logfile::repair(log, [&source] { return source.next(); }, message_key);
}

}  // namespace firn
