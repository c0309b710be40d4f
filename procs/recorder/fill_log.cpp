#include <algorithm>
#include <map>
#include <vector>

#include "procs/recorder/recorder.h"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

/// Sequence numbers as ranges: a channel without gaps costs one entry.
class Numbers {
 public:
  void add(std::int64_t n) {
    if (contains(n)) return;
    auto next = last_.find(n + 1);  // a range that begins right behind
    std::int64_t end = n;
    if (next != last_.end()) {
      end = next->second;
      last_.erase(next);
    }
    auto before = last_.lower_bound(n);
    if (before != last_.begin() && std::prev(before)->second == n - 1) std::prev(before)->second = end;
    else last_[n] = end;
  }
  bool contains(std::int64_t n) const {
    auto it = last_.upper_bound(n);
    return it != last_.begin() && std::prev(it)->second >= n;
  }

 private:
  std::map<std::int64_t, std::int64_t> last_;  // first -> last
};

using Present = std::map<std::string, Numbers, std::less<>>;

bool is_kept(std::string_view channel) {
  const ChannelInfo* row = find_channel(channel);
  return row && row->logged && row->delivery == Delivery::kReliable;
}

Present present_in(const fs::path& log) {
  Present present;
  if (!fs::exists(log)) return present;
  const logfile::EventLogFile file(log);
  auto reader = file.reader();
  while (const auto event = reader.next()) {
    const auto header = wire::read_header(event->data);
    if (!event->damaged && header && is_kept(event->channel)) present[std::string(event->channel)].add(header->seq);
  }
  return present;
}

struct Missing {
  std::int64_t utime_us;
  std::string channel;
  std::int64_t seq;
  std::vector<std::byte> bytes;
};

void find_missing(const fs::path& file, Present& present, std::vector<Missing>& missing) {
  const auto take = [&](std::string_view channel, std::span<const std::byte> bytes) {
    const auto header = wire::read_header(bytes);
    if (!header || !is_kept(channel)) return;
    Numbers& numbers = present[std::string(channel)];
    if (numbers.contains(header->seq)) return;
    numbers.add(header->seq);
    missing.push_back({header->utime_us, std::string(channel), header->seq, {bytes.begin(), bytes.end()}});
  };
  const logfile::MappedFile mapped(file);
  logfile::RecordReader reader(mapped.bytes());
  while (const auto record = reader.next()) {
    if (record->damaged) continue;
    if (record->kind == std::uint16_t(WalKind::kHead)) {
      const WalHead head = decode_head(record->payload);
      if (const NodeInfo* node = find_node(head.node)) take(channels::config(node->id).name, config_message(head));
    } else if (record->kind == std::uint16_t(WalKind::kOutputs)) {
      for (const Output& o : decode_output_list(decode_outputs(record->payload).body))
        if (o.kind == OutputKind::kSend) take(o.channel, o.bytes);
    }
  }
}

}  // namespace

std::size_t fill_log(const fs::path& run_dir) {
  const fs::path log = run_dir / "log.lcm";
  Present present = present_in(log);
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(run_dir / "nodes"))
    if (entry.path().extension() == ".wal" || entry.path().extension() == ".sent") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Missing> missing;
  for (const fs::path& file : files) find_missing(file, present, missing);
  std::stable_sort(missing.begin(), missing.end(), [](const Missing& a, const Missing& b) { return a.utime_us < b.utime_us; });
  logfile::EventLogWriter::Options options;
  options.mode = logfile::File::Mode::kAppend;
  logfile::EventLogWriter writer(log, options);
  for (const Missing& m : missing) writer.append(m.utime_us, m.channel, m.bytes);
  writer.sync();
  writer.close();
  return missing.size();
}

}  // namespace firn
