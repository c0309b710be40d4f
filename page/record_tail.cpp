#include "page/record_tail.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
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

constexpr std::string_view kFolder = "nodes/";
constexpr std::size_t kShownBytes = 60;            // of an exchange
constexpr std::uintmax_t kLargeBytes = 1'000'000;  // new in a file: it is worth a thread

}  // namespace

struct RecordTail::Found {
  std::int64_t utime_us = 0;
  std::string_view channel;
  std::span<const std::byte> message;
  Place place;
};

std::string Exchange::words() const {
  return "sent " + (sent.empty() ? "nothing" : sent) + " | received " +
         (received.empty() ? "nothing" : received);
}

RecordTail::RecordTail(std::filesystem::path run, std::set<std::string, std::less<>> wanted)
    : run_(std::move(run)), wanted_(std::move(wanted)) {
  for (const NodeInfo& node : nodes())
    for (const char* kind : {".wal", ".sent"}) {
      if (wanted_.empty() && !node.driver) continue;
      File& file = files_.emplace_back();
      file.name = std::string(kFolder) + std::string(node.name) + kind;
      file.driver = node.driver;
    }
}

RecordTail::~RecordTail() {
  if (folder_ >= 0) ::close(folder_);
}

// A time stands still for some milliseconds while files come: a folder that has just changed may change
// again.
bool RecordTail::folder_changed() {
  if (folder_ < 0) folder_ = ::open((run_ / "nodes").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  struct ::stat now {};
  if (folder_ < 0 || ::fstat(folder_, &now) != 0) return false;
  timespec clock{};
  ::clock_gettime(CLOCK_REALTIME, &clock);
  const bool other = now.st_mtim.tv_sec != folder_time_.tv_sec || now.st_mtim.tv_nsec != folder_time_.tv_nsec;
  folder_time_ = now.st_mtim;
  return other || std::abs(clock.tv_sec - now.st_mtim.tv_sec) <= 1;
}

bool RecordTail::changed(File& file) const {
  struct ::stat now {};
  if (folder_ < 0 || ::fstatat(folder_, file.name.c_str() + kFolder.size(), &now, 0) != 0) return false;
  const struct ::stat& seen = file.seen;
  if (file.map && now.st_ino == seen.st_ino && now.st_size == seen.st_size &&
      now.st_mtim.tv_sec == seen.st_mtim.tv_sec && now.st_mtim.tv_nsec == seen.st_mtim.tv_nsec)
    return false;
  file.seen = now;
  return true;
}

// A packed file has the bytes of the plain one that it took the place of.
void RecordTail::map(File& file) {
  file.map.reset();
  file.map = std::make_unique<logfile::MappedFile>(run_ / file.name);
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
    map(files_[n]);
    read_new(n, found_in[n]);
  };
  const bool look = folder_changed();
  std::vector<std::size_t> large;
  for (std::size_t n = 0; n < files_.size(); ++n) {
    if ((!files_[n].map && !look) || !changed(files_[n])) continue;
    grew[n] = 1;
    if (std::uint64_t(files_[n].seen.st_size) > files_[n].from + kLargeBytes)
      large.push_back(n);
    else
      read(n);
  }
  if (!large.empty()) parallel_on(0)(int(large.size()), [&](int k) { read(large[std::size_t(k)]); });
  if (std::ranges::count(grew, 1) == 0) return false;
  std::vector<Found> found;
  for (const auto& some : found_in) found.insert(found.end(), some.begin(), some.end());
  std::ranges::stable_sort(found, {}, &Found::utime_us);
  std::vector<std::byte> changed;
  for (const Found& f : found) {
    const auto message = migration_.today(f.message, changed);
    const ChannelInfo* row = find_channel(f.channel);
    if (row && !validate(*row, message)) sink(f.channel, message, f.place);
  }
  for (File& file : files_)
    if (file.map) file.map->forget();
  return true;
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
