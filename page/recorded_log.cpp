#include "page/recorded_log.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "files/record/checksum.h"
#include "files/record/event_format.h"
#include "firn/config_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"
#include "replay/channel_index.h"

namespace firn::page {

RecordedLog::RecordedLog(const std::filesystem::path& log)
    : log_(log), index_(logfile::MappedFile(logfile::index_path(log)).bytes()) {}

std::unique_ptr<RecordedLog> RecordedLog::open(const std::filesystem::path& run,
                                               const std::set<std::string, std::less<>>& wanted) try {
  std::unique_ptr<RecordedLog> log(new RecordedLog(run / "log.lcm"));
  if (log->index_.damage().count() > 0 || !log->find(wanted)) return nullptr;
  return log;
} catch (const std::exception&) {  // the write-ahead files are read then
  return nullptr;
}

std::optional<std::span<const std::byte>> RecordedLog::message(const logfile::IndexEntry& e) const {
  const std::span<const std::byte> bytes = log_.bytes();
  logfile::EventHeader h;
  if (e.offset > bytes.size() || e.bytes > bytes.size() - e.offset ||
      !logfile::plausible_event(bytes, e.offset, h) || h.bytes() != e.bytes ||
      logfile::checksum64(bytes.subspan(e.offset, e.bytes)) != e.checksum)
    return std::nullopt;
  return bytes.subspan(h.end() - std::uint64_t(h.data_bytes), std::size_t(h.data_bytes));
}

std::string RecordedLog::config() const {
  for (const logfile::IndexEntry& e : index_.entries()) {
    if (!index_.channel(e.channel).starts_with("CONFIG_")) continue;
    config_t m{};
    if (const auto bytes = message(e); bytes && m.decode(bytes->data(), 0, int(bytes->size())) > 0)
      return m.config_toml;
  }
  return "";
}

bool RecordedLog::find(const std::set<std::string, std::less<>>& wanted) {
  std::map<std::string_view, std::pair<const ChannelInfo*, std::vector<std::int64_t>>> numbers;
  std::int32_t newest = 0, ended = -1;  // incarnation
  std::uint64_t behind = 0;
  for (const logfile::IndexEntry& e : index_.entries()) {
    behind = std::max(behind, e.offset + e.bytes);
    const std::string_view name = index_.channel(e.channel);
    if (!wanted.contains(name)) continue;
    const auto m = message(e);
    const auto stamp = m ? replay::stamp_of(*m) : std::nullopt;
    const ChannelInfo* row = find_channel(name);
    if (!stamp || !row) return false;
    newest = std::max(newest, stamp->incarnation);
    if (name == channels::kRunEnd.name) ended = std::max(ended, stamp->incarnation);
    if (row->delivery == Delivery::kReliable) {
      auto& [same, seen] = numbers[row->name];
      same = row;
      seen.push_back(stamp->seq);
    }
    found_.push_back({stamp->utime_us, row->publisher, row->name, *m});
  }
  if (ended != newest || behind != log_.bytes().size()) return false;
  for (auto& [name, channel] : numbers) {
    std::ranges::sort(channel.second);
    for (std::size_t n = 0; n < channel.second.size(); ++n)
      if (channel.second[n] != std::int64_t(n) + 1) return false;
  }
  std::ranges::stable_sort(found_, {}, [](const Found& f) { return std::tuple(f.utime_us, f.publisher); });
  log_.forget();
  return true;
}

void RecordedLog::each(const RecordTail::Sink& sink) const {
  std::vector<std::byte> changed;
  for (const Found& f : found_) {
    const auto message = migration_.today(f.message, changed);
    const ChannelInfo* row = find_channel(f.channel);
    const Place place{0, std::uint64_t(f.message.data() - log_.bytes().data()),
                      std::uint32_t(f.message.size())};
    if (!validate(*row, message)) sink(f.channel, message, place);
  }
  log_.forget();
}

std::vector<std::byte> RecordedLog::read(const Place& place) const {
  const std::span<const std::byte> bytes = log_.bytes();
  if (place.at > bytes.size() || place.bytes > bytes.size() - place.at) return {};
  std::vector<std::byte> changed;
  const auto message = migration_.today(bytes.subspan(place.at, place.bytes), changed);
  std::vector<std::byte> kept(message.begin(), message.end());
  log_.forget();
  return kept;
}

}  // namespace firn::page
