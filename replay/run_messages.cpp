#include "replay/run_messages.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "replay/run_migration.h"

namespace firn::replay {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t kMostIncarnations = 1'000'000;  // a damaged number is no reason to take memory

}  // namespace

RunMessages::RunMessages(const fs::path& run) : found_(channels_.size()), by_channel_(channels_.size()) {
  if (!fs::is_directory(run / "nodes"))
    throw std::invalid_argument(run.string() + " is no run folder: it has no nodes/");
  for (const NodeInfo& node : nodes()) {
    const std::string name = "nodes/" + std::string(node.name) + ".wal";
    if (!fs::exists(run / name)) continue;
    read(*files_.emplace_back(std::make_unique<WalFile>(run / name)), name);
  }
  const RunMigration migration(run);
  std::vector<std::byte> changed;
  for (std::size_t c = 0; c < found_.size(); ++c) {
    for (const auto& [key, bytes] : found_[c]) {
      const auto today = migration.today(bytes, changed);
      by_channel_[c].push_back(today.data() == bytes.data() ? bytes
                                                            : migrated_.emplace_back(std::move(changed)));
    }
    found_[c].clear();
  }
  // An incarnation that ended before its START begins where the next one does.
  for (std::size_t n = starts_.size(); n-- > 1;)
    if (starts_[n - 1] == kNever) starts_[n - 1] = starts_[n];
}

void RunMessages::read(WalFile& file, const std::string& name) {
  std::vector<Output> outputs;
  for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
    if (item == WalFile::Item::kUnknown)
      damage_.push_back(name + ", byte " + std::to_string(file.offset()) + ": " + file.trouble());
    if (item != WalFile::Item::kStep && item != WalFile::Item::kStray) continue;
    const RecordedStep& step = file.step();
    if (item == WalFile::Item::kStep) {
      const Event& e = step.event;
      if (e.kind == EventKind::kMessage) keep(e.channel, e.bytes);
      if (e.kind == EventKind::kStart) {
        const std::size_t n = std::size_t(std::max(e.incarnation, 0));
        if (n <= kMostIncarnations) {
          if (n >= starts_.size()) starts_.resize(n + 1, kNever);
          starts_[n] = std::min(starts_[n], e.now.us);
        }
      }
    }
    if (!step.has_outputs) continue;
    try {
      decode_output_list(step.outputs, outputs);
      for (const Output& o : outputs)
        if (o.kind == OutputKind::kSend) keep(o.channel, o.bytes);
    } catch (const std::runtime_error& e) {
      damage_.push_back(name + ", step " + std::to_string(step.step) + ": " + e.what());
    }
  }
  for (const logfile::Damage& d : file.damage().list())
    damage_.push_back(name + ", byte " + std::to_string(d.offset) + ": " + std::string(d.reason));
}

void RunMessages::keep(std::string_view channel, std::span<const std::byte> bytes) {
  const int number = channels_.find(channel);
  const auto stamp = stamp_of(bytes);
  if (number >= 0 && stamp) found_[std::size_t(number)].try_emplace({stamp->incarnation, stamp->seq}, bytes);
}

const std::vector<std::span<const std::byte>>& RunMessages::on(std::string_view channel) const {
  static const std::vector<std::span<const std::byte>> kNone;
  const int number = channels_.find(channel);
  return number < 0 ? kNone : by_channel_[std::size_t(number)];
}

}  // namespace firn::replay
