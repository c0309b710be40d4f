#include "files/record/repair.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <tuple>

#include "files/record/event_log.h"

namespace firn::record {
namespace {

// One event of the new log. Old ones keep their order; an inserted one follows its predecessor's rank.
struct Piece {
  std::int64_t utime_us = 0;
  std::uint64_t rank = 0;       // order in the old log, of the event or of its predecessor
  std::uint64_t insertion = 0;  // 0 = from the old log
  std::string_view channel;
  std::span<const std::byte> data;
};

struct Known {
  std::int64_t utime_us;
  std::uint64_t rank;
  bool whole;
  std::size_t piece;
};

using ChannelKeys = std::map<MessageKey, Known>;

struct Plan {
  std::vector<Piece> pieces;
  std::map<std::string_view, ChannelKeys> keys;
  RepairReport report;
  bool in_order = true;
};

void read_log(const EventLogFile& file, const KeyOf& key_of, Plan& plan) {
  EventLogReader reader = file.reader();
  std::int64_t last_us = INT64_MIN;
  std::uint64_t rank = 0;
  while (const auto e = reader.next()) {
    ++rank;
    const auto key = key_of(e->channel, e->data);
    if (e->damaged) {
      ++plan.report.left_out;  // decremented when a source holds the whole event
      if (key) plan.keys[e->channel].try_emplace(*key, Known{e->utime_us, rank, false, 0});
      continue;
    }
    if (key) {
      auto [known, fresh] =
          plan.keys[e->channel].try_emplace(*key, Known{e->utime_us, rank, true, plan.pieces.size()});
      if (!fresh && known->second.whole) {
        ++plan.report.repeated;
        continue;
      }
      if (!fresh) {
        known->second = {e->utime_us, rank, true, plan.pieces.size()};
        --plan.report.left_out;
      }
    }
    plan.in_order = plan.in_order && e->utime_us >= last_us;
    last_us = e->utime_us;
    plan.pieces.push_back({e->utime_us, rank, 0, e->channel, e->data});
  }
  plan.report.damage = reader.damage();
}

ChannelGap& gap_of(RepairReport& report, std::string_view channel) {
  for (ChannelGap& g : report.gaps)
    if (g.channel == channel) return g;
  return report.gaps.emplace_back(ChannelGap{std::string(channel), 0, 0, INT64_MAX, INT64_MIN});
}

void insert_missing(const MessageSource& source, Plan& plan) {
  std::map<std::string_view, std::map<MessageKey, SourceMessage>> missing;
  while (const auto m = source()) {
    const auto channel = plan.keys.find(m->channel);
    if (channel != plan.keys.end())
      if (const auto known = channel->second.find(m->key);
          known != channel->second.end() && known->second.whole)
        continue;
    missing[m->channel].try_emplace(m->key, *m);
  }
  std::uint64_t insertion = 0;
  for (const auto& [channel, messages] : missing) {
    ChannelKeys& keys = plan.keys[channel];
    for (const auto& [key, m] : messages) {
      const auto at = keys.lower_bound(key);
      const bool replaces = at != keys.end() && at->first == key;  // a damaged one
      Piece piece{m.utime_us, 0, ++insertion, channel, m.data};
      if (replaces) {
        piece.utime_us = at->second.utime_us;
        piece.rank = at->second.rank;
        --plan.report.left_out;
      } else if (at != keys.begin()) {
        const Known& before = std::prev(at)->second;
        if (before.utime_us >= piece.utime_us) {
          piece.utime_us = before.utime_us;
          piece.rank = before.rank;
        }
      }
      keys.insert_or_assign(key, Known{piece.utime_us, piece.rank, true, plan.pieces.size()});
      plan.pieces.push_back(piece);
      ChannelGap& gap = gap_of(plan.report, channel);
      ++(replaces ? gap.replaced : gap.inserted);
      ++(replaces ? plan.report.replaced : plan.report.inserted);
      gap.first_utime_us = std::min(gap.first_utime_us, piece.utime_us);
      gap.last_utime_us = std::max(gap.last_utime_us, piece.utime_us);
    }
  }
}

std::filesystem::path keep_old(const std::filesystem::path& log) {
  for (int n = 1;; ++n) {
    const std::filesystem::path kept = log.string() + ".before-repair-" + std::to_string(n);
    if (std::filesystem::exists(kept)) continue;
    std::filesystem::create_hard_link(log, kept);
    return kept;
  }
}

std::string seconds(std::int64_t us) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6f s", double(us) * 1e-6);
  return text;
}

}  // namespace

RepairReport repair(const std::filesystem::path& log, const MessageSource& source, const KeyOf& key_of) {
  const bool exists = std::filesystem::exists(log);
  std::optional<File> lock;  // no recorder may continue to write the replaced log
  if (exists) lock.emplace(log, File::Mode::kAppend);
  std::optional<EventLogFile> old;
  if (exists) old.emplace(log);
  Plan plan;
  if (old) read_log(*old, key_of, plan);
  insert_missing(source, plan);
  RepairReport& report = plan.report;
  report.events = plan.pieces.size();
  const bool damaged = report.damage.count() > 0 || report.left_out > 0;
  const bool index_whole = old && old->has_index() && old->index().damage().count() == 0;
  report.rewritten =
      damaged || report.inserted + report.replaced + report.repeated > 0 || !plan.in_order || !index_whole;
  if (!report.rewritten) return report;

  std::sort(plan.pieces.begin(), plan.pieces.end(), [](const Piece& a, const Piece& b) {
    return std::tie(a.utime_us, a.rank, a.insertion) < std::tie(b.utime_us, b.rank, b.insertion);
  });
  const std::filesystem::path fresh = log.string() + ".repairing";
  std::filesystem::remove(fresh);
  std::filesystem::remove(index_path(fresh));
  try {
    EventLogWriter writer(fresh);
    for (const Piece& p : plan.pieces) writer.append(p.utime_us, p.channel, p.data);
    writer.sync();
    writer.close();
    if (damaged) report.kept_path = keep_old(log);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(fresh, ignored);
    std::filesystem::remove(index_path(fresh), ignored);
    throw;
  }
  // A stop between these lines leaves a log without an index, which is still readable, never a log with a
  // foreign index.
  std::filesystem::remove(index_path(log));
  std::filesystem::rename(fresh, log);
  std::filesystem::rename(index_path(fresh), index_path(log));
  sync_folder(log.has_parent_path() ? log.parent_path() : ".");
  return report;
}

std::vector<std::string> describe(const RepairReport& report) {
  std::vector<std::string> lines;
  for (const ChannelGap& g : report.gaps)
    lines.push_back("recording gap, repaired: " + std::to_string(g.inserted + g.replaced) + " messages of " +
                    g.channel + " between " + seconds(g.first_utime_us) + " and " + seconds(g.last_utime_us) +
                    (g.replaced ? ", " + std::to_string(g.replaced) + " of them damaged before" : ""));
  if (report.left_out)
    lines.push_back(std::to_string(report.left_out) +
                    " damaged events that no write-ahead file holds were left out; they stay in " +
                    report.kept_path.string());
  if (report.repeated) lines.push_back(std::to_string(report.repeated) + " repeated events dropped");
  return lines;
}

}  // namespace firn::record
