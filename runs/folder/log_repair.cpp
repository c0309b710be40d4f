#include "runs/folder/log_repair.h"

#include <algorithm>
#include <deque>

#include "files/record/packed.h"
#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "lcmtypes/channels.h"
#include "runs/folder/pack.h"
#include "runs/migrate/table.h"
#include "runtime/transport_wire.h"
#include "runtime/wal_file.h"
#include "runtime/write_ahead.h"

namespace firn::runs {
namespace {

using record::MessageSource;
using record::SourceMessage;

// The messages that were put out, file after file: nodes/*.wal of the nodes, nodes/*.sent of launcher and
// recorder.
class SentMessages {
 public:
  explicit SentMessages(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (RunPaths::is_sent_record(entry.path())) paths.push_back(entry.path());
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
    const bool wanted = channel ? channel->logged && channel->delivery == Delivery::kReliable
                                : runs::MigrationTable::builtin().retired(o.channel) != nullptr;
    if (!wanted || !header) return {};
    return SourceMessage{header->utime_us, o.channel, *message_key(o.channel, o.bytes), o.bytes};
  }

  // Reads the outputs of the next whole record that has some; damaged and undecodable records are skipped.
  bool next_outputs() {
    outputs_.clear();
    output_ = 0;
    while (outputs_.empty()) {
      if (!reader_) {
        if (file_ == files_.size()) return false;
        reader_.emplace(files_[file_++].bytes());
      }
      const auto record = reader_->next();
      if (!record)
        reader_.reset();
      else if (!record->damaged)
        take(*record);
    }
    return true;
  }

  void take(const record::Record& record) try {
    if (WalKind(record.kind) == WalKind::kOutputs) {
      outputs_ = decode_output_list(decode_outputs(record.payload).body);
    } else if (WalKind(record.kind) == WalKind::kHead) {
      // A node's CONFIG_ message goes out before its first step and is no output of one: the head holds its
      // content.
      const WalHead head = decode_head(record.payload);
      const NodeInfo* node = find_node(head.node);
      if (!node) return;
      configs_.push_back(config_message(head));
      Output config;
      config.kind = OutputKind::kSend;
      config.channel = channels::config(node->id).name;
      config.bytes = configs_.back();
      outputs_ = {config};
    }
  } catch (const std::runtime_error&) {
    outputs_.clear();
  }

  std::deque<record::MappedFile> files_;
  std::size_t file_ = 0;
  std::optional<record::RecordReader> reader_;
  std::vector<Output> outputs_;
  std::size_t output_ = 0;
  std::deque<std::vector<std::byte>> configs_;  // a deque: views of them are handed out
};

}  // namespace

std::optional<record::MessageKey> message_key(std::string_view channel, std::span<const std::byte> message) {
  if (!find_channel(channel) && !runs::MigrationTable::builtin().retired(channel)) return {};
  const auto header = wire::read_header(message);
  if (!header) return {};
  return record::MessageKey{std::uint64_t(header->incarnation), std::uint64_t(header->seq)};
}

void each_sent_message(const std::filesystem::path& nodes_folder,
                       const std::function<void(std::string_view channel, std::int64_t seq)>& use) {
  SentMessages source(nodes_folder);
  while (const auto m = source.next()) use(m->channel, std::int64_t(m->key.low));
}

record::RepairReport repair_from_write_ahead(const std::filesystem::path& log,
                                             const std::filesystem::path& nodes_folder) {
  if (record::is_packed(log)) expand_records(log.parent_path());  // the others are packed with its bytes
  SentMessages source(nodes_folder);
  return record::repair(
      log, [&source] { return source.next(); }, message_key);
}

}  // namespace firn::runs
