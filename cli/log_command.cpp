#include "cli/log_command.h"

#include <algorithm>
#include <iostream>
#include <map>
#include <ostream>

#include "cli/commands.h"
#include "cli/log_lines.h"
#include "cli/message_types.h"
#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/path/layer_file.h"
#include "files/path/trajectory_file.h"
#include "files/record/event_log.h"
#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/log_repair.h"
#include "runs/folder/run_lock.h"
#include "runs/migrate/run_migration.h"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

constexpr std::size_t kShownProblems = 20;

struct Channel {
  std::uint64_t messages = 0, missing = 0;
  std::int64_t last_seq = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> gaps;  // first, last seq
};

struct LogVerdict {
  std::string kind;
  std::uint64_t bytes = 0, pieces = 0, checked = 0;
  record::DamageList damage;
  std::vector<std::string> problems;  // of the content; the first kShownProblems are shown
  std::uint64_t problem_count = 0;
  std::map<std::string, Channel, std::less<>> channels;
  std::string note;

  void problem(const std::string& what) {
    if (++problem_count <= kShownProblems) problems.push_back(what);
  }
  bool ok() const { return damage.count() == 0 && problem_count == 0; }
};

bool is_record_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  for (const char* ending : {RunPaths::kWal, ".rec", ".paths", ".traj"})
    if (path.extension() == ending) return true;
  return record::RecordReader(bytes).header_ok();
}

// A trajectory file is known by its name, or under any name by its first record.
bool holds_trajectories(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  if (path.extension() == ".traj") return true;
  const auto first = record::RecordReader(bytes).next();
  return first && first->kind == std::uint16_t(TrajectoryRecord::kHead) && !RunPaths::is_wal(path) &&
         path.extension() != ".rec" && path.extension() != ".paths";
}

// A file of paths that ends between two records is whole to its records, but not to a printer.
void read_layers(LogVerdict& v, std::span<const std::byte> bytes) try {
  LayerReader layers(bytes);
  while (layers.next()) {
  }
} catch (const FormatError& e) {
  v.problem("byte " + std::to_string(e.offset) + ": " + e.problem);
}

void read_trajectories(LogVerdict& v, std::span<const std::byte> bytes) try {
  TrajectoryReader paths(bytes);
  while (paths.next()) {
  }
} catch (const TrajectoryFormatError& e) {
  v.problem("byte " + std::to_string(e.offset) + ": " + e.problem);
}

// Messages of reliable channels are numbered without gaps; a missing one is a gap of the recording.
void count_message(LogVerdict& v, const record::Event& e) {
  const auto it = v.channels.try_emplace(std::string(e.channel)).first;
  Channel& c = it->second;
  ++c.messages;
  const ChannelInfo* info = find_channel(e.channel);
  if (!info || e.damaged) return;
  std::vector<std::byte> changed;
  if (const auto wrong = validate(*info, runs::RunMigration().today(e.data, changed)))
    v.problem("event " + std::to_string(e.eventnum) + ": " + *wrong);
  const auto header = wire::read_header(e.data);
  if (!header || info->delivery != Delivery::kReliable) return;
  if (header->seq > c.last_seq + 1) {
    c.missing += std::uint64_t(header->seq - c.last_seq - 1);
    c.gaps.emplace_back(c.last_seq + 1, header->seq - 1);
  }
  c.last_seq = std::max(c.last_seq, header->seq);
}

// Says of each gap how much of it a repair would fill.
void count_gaps(LogVerdict& v, const std::filesystem::path& nodes) {
  std::map<std::string, std::uint64_t, std::less<>> held;
  const bool gaps = std::ranges::any_of(v.channels, [](const auto& c) { return c.second.missing > 0; });
  if (gaps && std::filesystem::is_directory(nodes))
    runs::each_sent_message(nodes, [&](std::string_view channel, std::int64_t seq) {
      const auto c = v.channels.find(channel);
      if (c == v.channels.end()) return;
      for (const auto& [first, last] : c->second.gaps)
        if (seq >= first && seq <= last) ++held[c->first];
    });
  for (const auto& [name, c] : v.channels) {
    if (!c.missing) continue;
    const std::uint64_t n = std::min(held[name], c.missing);
    v.problem("recording gap: " + std::to_string(c.missing) + " messages of " + name +
              (n == c.missing ? "; `firn log repair` fills it from the write-ahead files"
               : n > 0        ? "; the write-ahead files hold " + std::to_string(n) +
                             " of them, which `firn log repair` fills in"
                       : "; no write-ahead file in " + nodes.string() + " holds them"));
  }
}

LogVerdict verify_events(const std::filesystem::path& path) {
  const record::EventLogFile file(path);
  record::EventLogReader reader = file.reader();
  LogVerdict v;
  v.kind = "event log";
  v.bytes = file.bytes().size();
  if (!file.has_index())
    v.note = "no index beside it: changed payload bits cannot be seen";
  else if (reader.index_ignored())
    v.problem("the index belongs to another log");
  while (const auto e = reader.next()) {
    ++v.pieces;
    v.checked += e->checked;
    count_message(v, *e);
  }
  count_gaps(v, RunPaths(path.parent_path()).nodes_path());
  for (const record::Damage& d : file.index().damage().list())
    v.problem("index: byte " + std::to_string(d.offset) + ": " + std::string(d.reason));
  v.damage = reader.damage();
  return v;
}

LogVerdict verify_records(const std::filesystem::path& path) {
  const record::MappedFile file(path);
  record::RecordReader reader(file.bytes());
  LogVerdict v;
  const bool paths = path.extension() == ".paths", trajectories = holds_trajectories(path, file.bytes());
  v.kind = RunPaths::is_wal(path) ? "write-ahead file"
           : paths                ? "path file"
           : trajectories         ? "trajectory file"
                                  : "record file";
  v.bytes = file.bytes().size();
  while (const auto r = reader.next()) {
    ++v.pieces;
    v.checked += !r->damaged;
    const RecordLine line = record_line(*r, RunPaths::is_wal(path), {});
    if (!line.error.empty() && !r->damaged)
      v.problem("record " + std::to_string(r->index) + ": " + line.error);
  }
  v.damage = reader.damage();
  if (paths && v.damage.count() == 0) read_layers(v, file.bytes());
  if (trajectories && v.damage.count() == 0) read_trajectories(v, file.bytes());
  return v;
}

void print_json(const LogOptions& o, const LogVerdict& v, std::ostream& out) {
  out << "{\"ok\":" << (v.ok() ? "true" : "false") << ",\"file\":" << json_string(o.file)
      << ",\"kind\":" << json_string(v.kind) << ",\"bytes\":" << v.bytes << ",\"read\":" << v.pieces
      << ",\"checked\":" << v.checked << ",\"lost\":" << v.damage.lost()
      << ",\"damage_count\":" << v.damage.count() << ",\"damage\":[";
  for (std::size_t i = 0; i < v.damage.list().size(); ++i) {
    const record::Damage& d = v.damage.list()[i];
    out << (i ? "," : "") << "{\"offset\":" << d.offset << ",\"bytes\":" << d.bytes
        << ",\"reason\":" << json_string(d.reason) << ",\"lost\":" << d.lost << "}";
  }
  out << "],\"problem_count\":" << v.problem_count << ",\"problems\":[";
  for (std::size_t i = 0; i < v.problems.size(); ++i) out << (i ? "," : "") << json_string(v.problems[i]);
  out << "],\"channels\":{";
  const char* comma = "";
  for (const auto& [name, c] : v.channels) {
    out << comma << json_string(name) << ":{\"messages\":" << c.messages << ",\"missing\":" << c.missing
        << "}";
    comma = ",";
  }
  out << "}}\n";
}

void print_text(const LogOptions& o, const LogVerdict& v, std::ostream& out) {
  out << o.file << ": " << v.kind << ", " << v.bytes << " bytes, " << v.pieces << " read, " << v.checked
      << " with checksum, " << v.damage.lost() << " lost\n";
  if (!v.note.empty()) out << "  note: " << v.note << "\n";
  for (std::size_t i = 0; i < std::min(kShownProblems, v.damage.list().size()); ++i) {
    const record::Damage& d = v.damage.list()[i];
    out << "  byte " << d.offset << ": " << d.reason << " (" << d.bytes << " bytes, " << d.lost << " lost)\n";
  }
  if (v.damage.count() > kShownProblems) out << "  ... " << v.damage.count() << " damages in all\n";
  for (const std::string& p : v.problems) out << "  " << p << "\n";
  if (v.problem_count > kShownProblems) out << "  ... " << v.problem_count << " problems in all\n";
  out << (v.ok() ? "ok\n" : "DAMAGED\n");
}

bool wanted(const LogOptions& o, std::string_view channel) {
  return o.channels.empty() || std::find(o.channels.begin(), o.channels.end(), channel) != o.channels.end();
}
bool wanted(const LogOptions& o, std::int64_t us) {
  return double(us) * 1e-6 >= o.from_s && double(us) * 1e-6 <= o.to_s;
}

template <class Piece>
int finish_cat(const LogOptions& o, const record::DamageList& damage, Piece what, std::ostream& err) {
  for (const record::Damage& d : damage.list())
    err << o.file << ": byte " << d.offset << ": " << d.reason << " (" << d.lost << " " << what << " lost)\n";
  return damage.count() ? kFailed : kOk;
}

int cat_events(const LogOptions& o, const MessageTypes& types, std::ostream& out, std::ostream& err) {
  const record::EventLogFile file(o.file);
  record::EventLogReader reader = file.reader();
  const LineOptions json{{16, o.full}, &types};
  std::int64_t left = o.count;
  while (left != 0) {
    const auto e = reader.next();
    if (!e) break;
    file.forget_before(e->offset);
    if (!wanted(o, e->channel) || !wanted(o, e->utime_us)) continue;
    out << event_line(*e, json) << '\n';
    if (!out) return kFailed;  // nobody reads on
    if (left > 0) --left;
  }
  return finish_cat(o, reader.damage(), "events", err);
}

int cat_records(const LogOptions& o, const MessageTypes& types, std::ostream& out, std::ostream& err) {
  const record::MappedFile file(o.file);
  record::RecordReader reader(file.bytes());
  const LineOptions json{{16, o.full}, &types};
  std::int64_t left = o.count, now_us = 0;
  while (left != 0) {
    const auto r = reader.next();
    if (!r) break;
    const RecordLine line = record_line(*r, RunPaths::is_wal(o.file), json);
    now_us = line.now_us.value_or(now_us);
    const bool on_channel = o.channels.empty() || std::any_of(line.channels.begin(), line.channels.end(),
                                                              [&](const auto& c) { return wanted(o, c); });
    if (!on_channel || !wanted(o, now_us)) continue;
    out << line.json << '\n';
    if (!out) return kFailed;
    if (left > 0) --left;
  }
  return finish_cat(o, reader.damage(), "records", err);
}

bool is_records(const LogOptions& o) { return is_record_file(o.file, record::MappedFile(o.file).bytes()); }

}  // namespace

int log_verify(const LogOptions& o, std::ostream& out) {
  const LogVerdict v = is_records(o) ? verify_records(o.file) : verify_events(o.file);
  (o.json ? print_json : print_text)(o, v, out);
  return v.ok() ? kOk : kFailed;
}

int log_cat(const LogOptions& o, std::ostream& out, std::ostream& err) {
  const MessageTypes types(o.types);
  for (const std::string& problem : types.problems()) err << "firn log cat: note: " << problem << "\n";
  if (o.types.empty())
    for (const std::string& c : o.channels)
      if (!find_channel(c) && !runs::MigrationTable::builtin().retired(c))
        err << "firn log cat: note: channel " << c << " is not in Firn's table\n";
  return is_records(o) ? cat_records(o, types, out, err) : cat_events(o, types, out, err);
}

int log_repair(const LogOptions& o, std::ostream& out) {
  const std::filesystem::path log = o.file;
  // A run whose recorder died early has no log yet: it is made. Any other name is more likely a slip of the
  // pen.
  const bool there = std::filesystem::exists(log);
  if (!there && log.filename() != RunPaths::kLog) throw UsageError(o.file + ": no such file");
  if (there && is_records(o))
    throw UsageError(o.file + ": a write-ahead file is the record itself; only an event log can be repaired");
  const std::filesystem::path sources =
      o.sources.empty() ? RunPaths(log.parent_path()).nodes_path() : std::filesystem::path(o.sources);
  if (!std::filesystem::is_directory(sources))
    throw UsageError(sources.string() + ": no folder of write-ahead files to repair from");
  const std::filesystem::path run = std::filesystem::absolute(log).parent_path();
  const runs::RunLock lock(run, runs::RunUse::kWrite);
  const runs::SealCheck seals =
      std::filesystem::is_directory(RunPaths(run).seals_path()) ? runs::check_seals(run) : runs::SealCheck{};
  const record::RepairReport r = runs::repair_from_write_ahead(log, sources);
  if (r.rewritten) runs::seal_repaired(run, seals);
  if (o.json) {
    out << "{\"rewritten\":" << (r.rewritten ? "true" : "false") << ",\"events\":" << r.events
        << ",\"inserted\":" << r.inserted << ",\"replaced\":" << r.replaced << ",\"repeated\":" << r.repeated
        << ",\"left_out\":" << r.left_out << ",\"kept\":" << json_string(r.kept_path.string())
        << ",\"gaps\":[";
    for (std::size_t i = 0; i < r.gaps.size(); ++i)
      out << (i ? "," : "") << "{\"channel\":" << json_string(r.gaps[i].channel)
          << ",\"inserted\":" << r.gaps[i].inserted << ",\"replaced\":" << r.gaps[i].replaced
          << ",\"first_utime_us\":" << r.gaps[i].first_utime_us
          << ",\"last_utime_us\":" << r.gaps[i].last_utime_us << "}";
    out << "]}\n";
  } else {
    for (const std::string& line : describe(r)) out << line << "\n";
    out << o.file << ": " << r.events << " events, " << (r.rewritten ? "repaired" : "nothing to repair")
        << "\n";
  }
  return r.left_out ? kFailed : kOk;
}

int run_log(const LogOptions& o) try {
  if (std::filesystem::is_directory(o.file))
    throw UsageError(o.file + ": is a folder; give a file in it: log.lcm, nodes/<node>.wal or world.rec");
  switch (o.action) {
    case LogAction::kInfo:
      return log_info(o, std::cout);
    case LogAction::kVerify:
      return log_verify(o, std::cout);
    case LogAction::kCat:
      return log_cat(o, std::cout, std::cerr);
    case LogAction::kRepair:
      return log_repair(o, std::cout);
  }
  return kUsage;
} catch (const record::FileError& e) {
  if (o.action == LogAction::kRepair) throw;
  throw UsageError(e.what());
}

void declare_log(OptionSet& options) {
  const auto common = [](OptionSet& sub, LogAction action) -> LogOptions& {
    auto& o = sub.calls(run_log);
    o.action = action;
    sub.option("LOG", o.file, "log.lcm or another LCM log, nodes/<node>.wal or world.rec").required();
    if (action != LogAction::kCat) sub.json_flag(o.json);
    return o;
  };
  const auto types_option = [](OptionSet& sub, LogOptions& o) {
    sub.option("--types", o.types, "folder of .lcm files; may be repeated").one_value_each();
  };
  OptionSet info = options.subcommand("info", "channels, types, rates, gaps and time order of any LCM log");
  types_option(info, common(info, LogAction::kInfo));
  OptionSet verify =
      options.subcommand("verify", "checksums, gaps and limits; exit 1 if anything is damaged");
  common(verify, LogAction::kVerify);
  OptionSet cat = options.subcommand("cat", "one JSON object per event or record");
  auto& c = common(cat, LogAction::kCat);
  cat.option("-c,--channel", c.channels, "only this channel; may be repeated").one_value_each();
  cat.option("--from", c.from_s, "first node time [s]");
  cat.option("--to", c.to_s, "last node time [s]");
  cat.option("-n,--count", c.count, "at most so many lines");
  cat.flag("--full", c.full, "whole arrays");
  types_option(cat, c);
  OptionSet repair = options.subcommand("repair", "fills gaps from the write-ahead files");
  auto& r = common(repair, LogAction::kRepair);
  repair.option("--sources", r.sources, "folder of write-ahead files; default: nodes/ beside the log");
  options.require_subcommand();
}

}  // namespace firn
