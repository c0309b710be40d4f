#include "page/record_tail.h"

#include <algorithm>
#include <utility>

#include "files/record/record_file.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"
#include "replay/channel_index.h"
#include "replay/describe.h"
#include "runtime/thread_pool.h"
#include "runtime/write_ahead.h"

namespace firn::page {
namespace {

constexpr std::size_t kShownBytes = 60;            // of an exchange
constexpr std::uintmax_t kLargeBytes = 1'000'000;  // new in a file: it is worth a thread

}  // namespace

struct RecordTail::Found {
  std::int64_t utime_us = 0;
  std::string_view channel;
  std::span<const std::byte> message;
  Place place;
};

RecordTail::RecordTail(std::filesystem::path run, std::set<std::string, std::less<>> wanted)
    : run_(std::move(run)), wanted_(std::move(wanted)) {
  for (const NodeInfo& node : nodes())
    for (const char* kind : {".wal", ".sent"}) {
      File& file = files_.emplace_back();
      file.name = "nodes/" + std::string(node.name) + kind;
      file.driver = node.driver;
    }
}

// Maps a file anew if it has changed. A packed file has the bytes of the plain one that it took the place of.
bool RecordTail::map(File& file) {
  struct ::stat now {};
  const std::filesystem::path path = run_ / file.name;
  if (::stat(path.c_str(), &now) != 0) return false;
  const struct ::stat& seen = file.seen;
  if (file.map && now.st_ino == seen.st_ino && now.st_size == seen.st_size &&
      now.st_mtim.tv_sec == seen.st_mtim.tv_sec && now.st_mtim.tv_nsec == seen.st_mtim.tv_nsec)
    return false;
  file.map = std::make_unique<logfile::MappedFile>(path);
  file.seen = now;
  return true;
}

void RecordTail::read_new(std::size_t number, std::vector<Found>& found) {
  File& file = files_[number];
  const std::span<const std::byte> bytes = file.map->bytes();
  logfile::RecordReader reader(bytes, file.from, file.index);
  std::vector<Output> outputs;
  std::optional<std::span<const std::byte>> sent, received;
  while (const auto record = reader.next()) {
    if (record->damaged) continue;
    try {
      if (WalKind(record->kind) == WalKind::kEvent && file.driver) {
        const Event event = decode_event(record->payload).event;
        if (event.kind != EventKind::kIo) continue;
        received = event.bytes;
      }
      if (WalKind(record->kind) != WalKind::kOutputs) continue;
      decode_output_list(decode_outputs(record->payload).body, outputs);
    } catch (const std::runtime_error&) {  // replay and `firn log verify` name the place
      continue;
    }
    for (const Output& o : outputs) {
      if (o.kind == OutputKind::kWrite) sent = o.bytes;
      if (o.kind != OutputKind::kSend || !wanted_.contains(o.channel)) continue;
      const auto stamp = replay::stamp_of(o.bytes);
      if (!stamp) continue;
      const Place place{number, std::uint64_t(o.bytes.data() - bytes.data()), std::uint32_t(o.bytes.size())};
      found.push_back({stamp->utime_us, o.channel, o.bytes, place});
    }
  }
  if (sent) file.sent = replay::escaped(*sent, kShownBytes);
  if (received) file.received = replay::escaped(*received, kShownBytes);
  file.exchanged = file.exchanged || sent || received;
  file.from = reader.valid_end();
  file.index = reader.valid_next_index();
}

bool RecordTail::poll(const Sink& sink) {
  std::vector<std::vector<Found>> found_in(files_.size());
  std::vector<char> grew(files_.size(), 0);
  const auto read = [&](std::size_t n) {
    grew[n] = map(files_[n]);
    if (grew[n]) read_new(n, found_in[n]);
  };
  std::vector<std::size_t> large;
  for (std::size_t n = 0; n < files_.size(); ++n) {
    std::error_code missing;
    const std::uintmax_t bytes = std::filesystem::file_size(run_ / files_[n].name, missing);
    if (!missing && bytes > files_[n].from + kLargeBytes)
      large.push_back(n);
    else
      read(n);
  }
  if (!large.empty()) parallel_on(0)(int(large.size()), [&](int k) { read(large[std::size_t(k)]); });
  std::vector<Found> found;
  for (const auto& some : found_in) found.insert(found.end(), some.begin(), some.end());
  const bool grown = std::ranges::count(grew, 1) > 0;
  std::ranges::stable_sort(found, {}, &Found::utime_us);
  std::vector<std::byte> changed;
  for (const Found& f : found) {
    const auto message = migration_.today(f.message, changed);
    const ChannelInfo* row = find_channel(f.channel);
    if (row && !validate(*row, message)) sink(f.channel, message, f.place);
  }
  for (File& file : files_)
    if (file.map) file.map->forget();
  return grown;
}

std::vector<std::byte> RecordTail::read(const Place& place) {
  const File& file = files_.at(place.file);
  if (!file.map) return {};
  const std::span<const std::byte> bytes = file.map->bytes();
  if (place.at > bytes.size() || place.bytes > bytes.size() - place.at) return {};
  std::vector<std::byte> changed;
  const auto message = migration_.today(bytes.subspan(place.at, place.bytes), changed);
  std::vector<std::byte> kept(message.begin(), message.end());
  file.map->forget();
  return kept;
}

std::vector<Exchange> RecordTail::take_exchanges() {
  std::vector<Exchange> all;
  for (File& file : files_) {
    if (!std::exchange(file.exchanged, false)) continue;
    const std::size_t slash = file.name.find('/') + 1;
    all.push_back({file.name.substr(slash, file.name.rfind('.') - slash), file.sent, file.received});
  }
  return all;
}

}  // namespace firn::page
