#include "replay/run_messages.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "replay/bytes.h"
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
    for (const char* kind : {".wal", ".sent"}) {
      const std::string name = "nodes/" + std::string(node.name) + kind;
      if (fs::exists(run / name))
        read(*files_.emplace_back(std::make_unique<WalFile>(run / name)), name, node.name);
    }
  }
  compare_received();
  const RunMigration migration(run);
  std::vector<std::byte> changed;
  for (std::size_t c = 0; c < found_.size(); ++c) {
    for (const auto& [key, found] : found_[c]) {
      const auto bytes = found.bytes;
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

void RunMessages::read(WalFile& file, const std::string& name, std::string_view node) {
  senders_.insert(node);
  const std::size_t damage_before = damage_.size();
  std::vector<Output> outputs;
  for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
    if (item == WalFile::Item::kUnknown)
      damage_.push_back(name + ", byte " + std::to_string(file.offset()) + ": " + file.trouble());
    if (item != WalFile::Item::kStep && item != WalFile::Item::kStray) continue;
    const RecordedStep& step = file.step();
    if (item == WalFile::Item::kStep) {
      const Event& e = step.event;
      if (e.kind == EventKind::kMessage) keep_received(e.channel, e.bytes, step.damaged_at ? "" : node);
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
        if (o.kind == OutputKind::kSend && step.damaged_at)
          keep_received(o.channel, o.bytes, "");
        else if (o.kind == OutputKind::kSend)
          keep_sent(o.channel, o.bytes);
    } catch (const std::runtime_error& e) {
      damage_.push_back(name + ", step " + std::to_string(step.step) + ": " + e.what());
    }
  }
  for (const logfile::Damage& d : file.damage().list())
    damage_.push_back(name + ", byte " + std::to_string(d.offset) + ": " + std::string(d.reason));
  if (damage_.size() > damage_before) damaged_senders_.insert(node);
}

void RunMessages::keep_sent(std::string_view channel, std::span<const std::byte> bytes) {
  const int number = channels_.find(channel);
  const auto stamp = stamp_of(bytes);
  if (number < 0 || !stamp) return;
  Found& found = found_[std::size_t(number)][{stamp->incarnation, stamp->seq}];
  if (!found.sent) found = {bytes, true};
}

void RunMessages::keep_received(std::string_view channel, std::span<const std::byte> bytes,
                                std::string_view by) {
  const int number = channels_.find(channel);
  const auto stamp = stamp_of(bytes);
  if (number < 0 || !stamp) return;
  const Key key{stamp->incarnation, stamp->seq};
  found_[std::size_t(number)].try_emplace(key, Found{bytes, false});
  if (!by.empty()) received_.push_back({number, key, bytes, by});
}

// A damaged file has lost messages. The launcher tells of a full disk, which its own file is on,
// nevertheless.
bool RunMessages::may_lack(const ChannelInfo& channel) const {
  return damaged_senders_.contains(info(channel.publisher).name) ||
         (!sent_by_node(channel) && channel.name.starts_with("FAULT_"));
}

// A node writes a message to its file before the message leaves, so that no kill separates the two.
void RunMessages::compare_received() {
  std::set<std::pair<int, Key>> told;
  for (const Received& r : received_) {
    const ChannelInfo& channel = channel_table()[std::size_t(r.channel)];
    const std::string_view publisher = info(channel.publisher).name;
    if (of_the_runner(channel) || !senders_.contains(publisher)) continue;
    const Found& found = found_[std::size_t(r.channel)].at(r.key);
    if (found.sent ? same_bytes(found.bytes, r.bytes) : may_lack(channel)) continue;
    if (!told.emplace(r.channel, r.key).second) continue;
    forged_.push_back(std::string(channel.name) + " " + std::to_string(r.key.second) + " of incarnation " +
                      std::to_string(r.key.first) + ", received by " + std::string(r.by) + ": " +
                      std::string(publisher) + (found.sent ? " sent other bytes" : " did not send it"));
  }
  received_.clear();
}

const std::vector<std::span<const std::byte>>& RunMessages::on(std::string_view channel) const {
  static const std::vector<std::span<const std::byte>> kNone;
  const int number = channels_.find(channel);
  return number < 0 ? kNone : by_channel_[std::size_t(number)];
}

}  // namespace firn::replay
