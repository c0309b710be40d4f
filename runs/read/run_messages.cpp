#include "runs/read/run_messages.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "files/record/pages.h"
#include "runs/folder/one_run.h"
#include "runs/folder/run_folder.h"
#include "runs/migrate/run_migration.h"

namespace firn::runs {
namespace {

constexpr std::uint64_t kHeldOfLog_bytes = std::uint64_t(4) << 20;  // in memory

// Messages of earlier versions may need others of their time, which the write-ahead files have
// (companions.h).
bool of_today(const WholeLog& log) {
  const RunMigration migration;
  std::vector<std::byte> changed;
  return std::ranges::all_of(log.messages, [&](const LoggedMessage& m) {
    log.file.forget_before(std::uint64_t(m.bytes.data() - log.file.bytes().data()));
    return migration.today(m.bytes, changed).data() == m.bytes.data();
  });
}

}  // namespace

RunMessages::RunMessages(const std::filesystem::path& run, const Channels& wanted) : wanted_(wanted) {
  require_run(run);
  require_one_run(run);
  log_ = read_whole_log(run, wanted);
  if (log_ && !of_today(*log_)) log_.reset();
  if (!log_) {
    files_ = std::make_unique<RunReader>(run);
    return;
  }
  std::vector<LoggedMessage> messages = std::move(log_->messages);
  const auto key = [](const LoggedMessage& m) {
    return std::tuple(m.channel, m.stamp.incarnation, m.stamp.seq);
  };
  std::ranges::stable_sort(messages, {}, key);
  const auto same = [&](const LoggedMessage& a, const LoggedMessage& b) { return key(a) == key(b); };
  messages.erase(std::unique(messages.begin(), messages.end(), same), messages.end());
  by_channel_.resize(channel_table().size());
  for (const LoggedMessage& m : messages)
    by_channel_[std::size_t(m.channel - channel_table().data())].push_back(m.bytes);
}

const std::vector<std::span<const std::byte>>& RunMessages::on(std::string_view channel) const {
  if (!wanted_.contains(channel))
    throw std::logic_error("RunMessages: channel " + std::string(channel) + " is not wanted");
  if (files_) return files_->on(channel);
  return by_channel_[std::size_t(find_channel(channel) - channel_table().data())];
}

int RunMessages::incarnations() const { return files_ ? int(files_->starts().size()) : log_->incarnations; }

void RunMessages::Passed::message(std::span<const std::byte> bytes) {
  if (!file_ || !file_->of_file()) return;
  const auto at = std::uint64_t(bytes.data() - file_->bytes().data());
  if (at >= from_ && at < from_ + kHeldOfLog_bytes) return;
  if (at > from_) record::forget_pages(file_->bytes(), from_, at);
  from_ = at;
}

}  // namespace firn::runs
