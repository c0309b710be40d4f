#include "replay/log_check.h"

#include <algorithm>
#include <optional>

#include "files/record/event_log.h"
#include "files/run_paths.h"
#include "runs/read/bytes.h"

namespace firn::replay {
namespace {

class LogCheck {
 public:
  LogCheck(const SentIndex& sent, const runs::ChannelIndex& channels, const runs::RunMigration& migration,
           MessageComparer& comparer, RunVerdict& verdict)
      : sent_(sent),
        channels_(channels),
        migration_(migration),
        comparer_(comparer),
        verdict_(verdict),
        seen_(channels.size()) {
    for (std::size_t c = 0; c < seen_.size(); ++c) seen_[c].resize(sent.all(int(c)).size());
  }

  void event(const record::Event& e) {
    const int number = channels_.find(e.channel);
    if (number < 0) return;
    const ChannelInfo& channel = channel_table()[std::size_t(number)];
    if (!runs::sent_by_node(channel) || !sent_.knows(number)) return;
    const std::optional<runs::Stamp> stamp = runs::stamp_of(e.data);
    const std::optional<std::size_t> position = stamp ? sent_.position(number, stamp->seq) : std::nullopt;
    const Sent* s = position ? &sent_.all(number)[*position] : nullptr;
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
    seen_[std::size_t(number)][*position] = true;
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
      if (channel.delivery != Delivery::kReliable || !channel.logged) continue;
      const std::deque<Sent>& all = sent_.all(int(c));
      const Sent* first = nullptr;
      std::uint64_t gaps = 0;
      for (std::size_t n = 0; n < all.size(); ++n)
        if (!seen_[c][n] && !all[n].cut && !all[n].differs) {
          if (!first) first = &all[n];
          ++gaps;
        }
      if (!first) continue;
      add(finding(channel, first,
                  "log.lcm lacks this" + (gaps > 1 ? " and " + std::to_string(gaps - 1) + " more" : "") +
                      " (`firn log repair` fills it from the write-ahead files)"));
    }
  }

 private:
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
  std::vector<std::vector<bool>> seen_;  // by channel, by position in SentIndex::all
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
    sent.read(event->data.size());
    file.forget_before(event->offset);
  }
  check.missing();
  for (const record::Damage& d : reader.damage().list())
    verdict.damage.push_back({RunPaths::kLog, d.offset, d.bytes, std::string(d.reason), {}});
}

}  // namespace firn::replay
