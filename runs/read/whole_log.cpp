#include "runs/read/whole_log.h"

#include <algorithm>
#include <exception>
#include <map>
#include <string_view>
#include <utility>

#include "files/record/checksum.h"
#include "files/record/event_format.h"
#include "files/record/event_index.h"
#include "files/run_paths.h"
#include "firn/config_t.hpp"

namespace firn::runs {
namespace {

std::optional<std::span<const std::byte>> message_of(const record::IndexEntry& e,
                                                     std::span<const std::byte> log) {
  record::EventHeader h;
  if (e.offset > log.size() || e.bytes > log.size() - e.offset ||
      !record::plausible_event(log, e.offset, h) || h.bytes() != e.bytes ||
      record::checksum64(log.subspan(e.offset, e.bytes)) != e.checksum)
    return std::nullopt;
  return log.subspan(h.end() - std::uint64_t(h.data_bytes), std::size_t(h.data_bytes));
}

// Numbers of the messages of one reliable channel: 1, 2, 3, … without a gap.
bool whole(std::vector<std::int64_t>& numbers) {
  std::ranges::sort(numbers);
  for (std::size_t n = 0; n < numbers.size(); ++n)
    if (numbers[n] != std::int64_t(n) + 1) return false;
  return true;
}

// Reads entry after entry. The end of the run is looked for whether it is wanted or not.
class Reading {
 public:
  Reading(WholeLog& log, const std::set<std::string, std::less<>>& channels)
      : log_(log), bytes_(log.file.bytes()), channels_(channels) {}

  /// @returns false: the log cannot stand for the files
  bool take(const record::IndexEntry& e, std::string_view name) {
    behind_ = std::max(behind_, e.offset + e.bytes);
    const bool config = name.starts_with("CONFIG_"), wanted = channels_.contains(name);
    if (!config && !wanted && name != channels::kRunEnd.name) return true;
    const auto m = message_of(e, bytes_);
    const auto stamp = m ? stamp_of(*m) : std::nullopt;
    const ChannelInfo* row = find_channel(name);
    if (!stamp || !row) return config && !wanted;
    newest_ = std::max(newest_, stamp->incarnation);
    if (config_t c{}; config && log_.config.empty() && c.decode(m->data(), 0, int(m->size())) > 0)
      log_.config = c.config_toml;
    if (row->name == channels::kRunEnd.name) ended_ = std::max(ended_, stamp->incarnation);
    if (!wanted) return true;
    if (row->delivery == Delivery::kReliable) numbers_[row->name].push_back(stamp->seq);
    log_.messages.push_back({row, *stamp, *m});
    log_.file.forget_before(e.offset);
    return true;
  }

  bool whole_to_the_end() {
    log_.incarnations = newest_ + 1;
    return ended_ == newest_ && behind_ == bytes_.size() &&
           std::ranges::all_of(numbers_, [](auto& channel) { return whole(channel.second); });
  }

 private:
  WholeLog& log_;
  std::span<const std::byte> bytes_;
  const std::set<std::string, std::less<>>& channels_;
  std::map<std::string_view, std::vector<std::int64_t>> numbers_;  // of reliable channels
  std::int32_t newest_ = 0, ended_ = -1;                           // incarnation
  std::uint64_t behind_ = 0;
};

}  // namespace

std::optional<WholeLog> read_whole_log(const std::filesystem::path& run,
                                       const std::set<std::string, std::less<>>& channels) try {
  for (const std::string& name : channels)
    if (const ChannelInfo* row = find_channel(name); !row || !row->logged) return std::nullopt;
  const std::filesystem::path path = RunPaths(run).log_path();
  const record::MappedFile index(record::index_path(path));
  WholeLog log{record::MappedFile(path), {}, {}, 0};
  Reading reading(log, channels);
  bool sound = true;
  sound = record::each_entry(index, [&](const record::IndexEntry& e,
                                        std::string_view name) { return sound = reading.take(e, name); }) &&
          sound;
  if (!sound || !reading.whole_to_the_end()) return std::nullopt;
  log.file.forget();
  return log;
} catch (const std::exception&) {  // the write-ahead files are read then
  return std::nullopt;
}

}  // namespace firn::runs
