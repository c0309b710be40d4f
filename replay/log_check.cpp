#include "replay/log_check.h"

#include <iterator>
#include <map>
#include <optional>

#include "files/record/event_log.h"
#include "files/run_paths.h"
#include "runs/read/bytes.h"

namespace firn::replay {
namespace {

/// Places that were seen, as ranges: those of a whole log, which come in their order, are one.
class SeenPlaces {
 public:
  void add(std::size_t place) {
    auto next = ranges_.upper_bound(place);
    auto range = next == ranges_.begin() ? ranges_.end() : std::prev(next);
    if (range != ranges_.end() && place < range->second) return;
    if (range != ranges_.end() && place == range->second)
      ++range->second;
    else
      range = ranges_.emplace_hint(next, place, place + 1);
    if (next == ranges_.end() || next->first != range->second) return;
    range->second = next->second;
    ranges_.erase(next);
  }
  /// Calls `use` with each place below `size` that was not seen.
  template <class Use>
  void each_other(std::size_t size, const Use& use) const {
    std::size_t place = 0;
    for (const auto& [first, behind] : ranges_) {
      for (; place < first; ++place) use(place);
      place = behind;
    }
    for (; place < size; ++place) use(place);
  }

 private:
  std::map<std::size_t, std::size_t> ranges_;  // [first, second)
};

class LogCheck {
 public:
  LogCheck(const SentIndex& sent, const runs::ChannelIndex& channels, const runs::RunMigration& migration,
           MessageComparer& comparer, RunVerdict& verdict)
      : sent_(sent),
        channels_(channels),
        migration_(migration),
        comparer_(comparer),
        verdict_(verdict),
        seen_(channels.size()) {}

  void event(const record::Event& e) {
    const int number = channels_.find(e.channel);
    if (number < 0) return;
    const ChannelInfo& channel = channel_table()[std::size_t(number)];
    if (!runs::sent_by_node(channel) || !sent_.knows(number)) return;
    const std::optional<runs::Stamp> stamp = runs::stamp_of(e.data);
    const std::optional<std::size_t> position = stamp ? sent_.position(number, stamp->seq) : std::nullopt;
    const Sent* s = position ? &sent_.at_place(number, *position) : nullptr;
    ++verdict_.log_messages;
    if (!s) {
      Finding f = finding(channel, nullptr,
                          "log.lcm, byte " + std::to_string(e.offset) +
                              ", holds a message that the publisher's write-ahead file lacks");
      if (stamp) {
        f.seq = stamp->seq;
        f.at = Time{stamp->utime_us};
        f.step = sent_.step_after(number, stamp->seq);
      }
      add(std::move(f));
      return;
    }
    if (must_be_logged(channel)) seen_[std::size_t(number)].add(*position);
    const std::span<const std::byte> data = migration_.today(e.data, migrated_);
    if (s->differs || runs::same_bytes(s->bytes, data)) return;
    const auto difference = comparer_.compare(channel, s->bytes, data);
    if (!difference) return;
    Finding f = finding(channel, s,
                        "the message in log.lcm, byte " + std::to_string(e.offset) +
                            ", is not what the publisher's write-ahead file holds");
    f.field = difference->path;
    f.recorded = difference->a;
    f.replayed = difference->b;
    add(std::move(f));
  }

  void missing() {
    for (std::size_t c = 0; c < seen_.size(); ++c) {
      const ChannelInfo& channel = channel_table()[c];
      const SentList* all = sent_.all(int(c));
      if (!must_be_logged(channel) || !all) continue;
      std::optional<Sent> first;
      std::uint64_t gaps = 0;
      seen_[c].each_other(all->size(), [&](std::size_t n) {
        const Sent& sent = (*all)[n];
        if (sent.cut || sent.differs) return;
        if (!first) first = sent;
        ++gaps;
      });
      if (!first) continue;
      add(finding(channel, &*first,
                  "log.lcm lacks this" + (gaps > 1 ? " and " + std::to_string(gaps - 1) + " more" : "") +
                      " (`firn log repair` fills it from the write-ahead files)"));
    }
  }

 private:
  static bool must_be_logged(const ChannelInfo& channel) {
    return channel.delivery == Delivery::kReliable && channel.logged;
  }

  Finding finding(const ChannelInfo& channel, const Sent* s, std::string what) {
    Finding f;
    f.kind = FindingKind::kLog;
    f.node = info(channel.publisher).name;
    f.channel = channel.name;
    f.what = std::move(what);
    if (!s) return f;
    f.step = s->step;
    f.seq = s->seq;
    f.at = s->at;
    return f;
  }

  void add(Finding f) {
    ++verdict_.findings_total;
    if (++kept_ <= RunVerdict::kKeptPerNode) verdict_.findings.push_back(std::move(f));
  }

  const SentIndex& sent_;
  const runs::ChannelIndex& channels_;
  const runs::RunMigration& migration_;
  std::vector<std::byte> migrated_;  // the current message; storage used again
  MessageComparer& comparer_;
  RunVerdict& verdict_;
  std::vector<SeenPlaces> seen_;  // by channel: positions in SentIndex::all
  std::size_t kept_ = 0;
};

}  // namespace

void check_log(const std::filesystem::path& run, const SentIndex& sent, const runs::ChannelIndex& channels,
               const runs::RunMigration& migration, MessageComparer& comparer, RunVerdict& verdict) {
  const std::filesystem::path path = RunPaths(run).log_path();
  verdict.log_present = std::filesystem::exists(path);
  if (!verdict.log_present) return;
  const record::EventLogFile file(path);
  record::EventLogReader reader = file.reader();
  LogCheck check(sent, channels, migration, comparer, verdict);
  while (const auto event = reader.next()) {
    check.event(*event);
    file.forget_before(event->offset);
  }
  check.missing();
  for (const record::Damage& d : reader.damage().list())
    verdict.damage.push_back({RunPaths::kLog, d.offset, d.bytes, std::string(d.reason), {}});
}

}  // namespace firn::replay
