#include "runs/read/run_reader.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "files/record/pages.h"
#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"
#include "runs/folder/one_run.h"
#include "runs/folder/run_folder.h"
#include "runs/read/bytes.h"
#include "runs/read/companions.h"
#include "runs/read/describe.h"
#include "runs/read/whole_log.h"
#include "runtime/thread_pool.h"
#include "runtime/write_ahead.h"

namespace firn::runs {
namespace {

constexpr std::size_t kShownBytes = 60;                        // of an exchange
constexpr std::uint64_t kHeld_bytes = std::uint64_t(2) << 20;  // of a mapped file, in memory
constexpr std::uintmax_t kLargeBytes = 1'000'000;              // new in a file: it is worth a thread
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t kMaxIncarnations = 1'000'000;  // a damaged number is no reason to take memory

}  // namespace

std::string Exchange::words() const {
  return "sent " + (sent.empty() ? "nothing" : sent) + " | received " +
         (received.empty() ? "nothing" : received);
}

RunReader::RunReader(std::filesystem::path run, Channels wanted, Source source)
    : run_(std::move(run)), wanted_(std::move(wanted)) {
  reads_log_ = source == Source::kLog && open_log();
  if (!reads_log_) name_files();
}

RunReader::RunReader(const std::filesystem::path& run)
    : run_(run), migration_(migration_of(run)), reads_all_(true) {
  require_run(run);
  require_one_run(run);
  name_files();
  take_all();
}

RunReader::~RunReader() {
  if (folder_ >= 0) ::close(folder_);
}

void RunReader::name_files() {
  files_.clear();
  logged_.clear();
  config_.clear();
  for (const NodeInfo& node : nodes()) {
    const bool publishes = std::ranges::any_of(channel_table(), [&](const ChannelInfo& channel) {
      return channel.publisher == node.id && wanted_.contains(channel.name);
    });
    if (!reads_all_ && (wanted_.empty() ? !node.driver : !publishes)) continue;
    for (const std::string& name : {RunPaths::wal_name(node.name), RunPaths::sent_name(node.name)}) {
      File& file = files_.emplace_back();
      file.name = name;
      file.driver = node.driver;
    }
  }
}

bool RunReader::open_log() {
  auto log = read_whole_log(run_, wanted_);
  if (!log) return false;
  File& file = files_.emplace_back();
  file.name = RunPaths::kLog;
  file.map = std::make_unique<record::MappedFile>(std::move(log->file));
  config_ = std::move(log->config);
  for (const LoggedMessage& m : log->messages)
    logged_.push_back({m.stamp, std::size_t(m.channel->publisher), m.channel, m.bytes, 0, Copy::kSent});
  return true;
}

// A time stands still for some milliseconds while files come: a folder that has just changed may change
// again.
bool RunReader::folder_changed() {
  if (folder_ < 0) folder_ = ::open(RunPaths(run_).nodes_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  struct ::stat now {};
  if (folder_ < 0 || ::fstat(folder_, &now) != 0) return false;
  timespec clock{};
  ::clock_gettime(CLOCK_REALTIME, &clock);
  const bool other = now.st_mtim.tv_sec != folder_time_.tv_sec || now.st_mtim.tv_nsec != folder_time_.tv_nsec;
  folder_time_ = now.st_mtim;
  return other || std::abs(clock.tv_sec - now.st_mtim.tv_sec) <= 1;
}

bool RunReader::changed(File& file) const {
  struct ::stat now {};
  const char* const name = file.name.c_str() + file.name.find('/') + 1;
  if (folder_ < 0 || ::fstatat(folder_, name, &now, 0) != 0) return false;
  const struct ::stat& seen = file.seen;
  if (file.map && now.st_ino == seen.st_ino && now.st_size == seen.st_size &&
      now.st_mtim.tv_sec == seen.st_mtim.tv_sec && now.st_mtim.tv_nsec == seen.st_mtim.tv_nsec)
    return false;
  file.seen = now;
  return true;
}

// A packed file has the bytes of the plain one that it took the place of.
void RunReader::map(File& file) {
  file.map.reset();
  file.map = std::make_unique<record::MappedFile>(run_ / file.name);
}

// Reads the new records of one file. A reader of all messages takes damaged records and deliveries too.
class RunReader::Scan {
 public:
  Scan(RunReader& reader, std::size_t number, std::vector<Found>& found)
      : run_(reader), number_(number), file_(reader.files_[number]), found_(found) {}

  void go() {
    record::RecordReader reader(file_.map->bytes(), file_.from, file_.index);
    while (const auto record = reader.next()) {
      file_.map->forget_before(record->offset);
      if (record->damaged && !run_.reads_all_) continue;
      try {
        take(*record);
      } catch (const std::runtime_error& e) {
        note("byte", record->offset, e.what());
      }
    }
    for (const record::Damage& d : reader.damage().list()) note("byte", d.offset, std::string(d.reason));
    if (sent_) file_.sent = escaped(*sent_, kShownBytes);
    if (received_) file_.received = escaped(*received_, kShownBytes);
    file_.exchanged = file_.exchanged || sent_ || received_;
    file_.from = reader.valid_end();
    file_.index = reader.valid_next_index();
  }

 private:
  struct Step {
    std::uint64_t number = 0;
    bool damaged = false;
    std::optional<std::size_t> delivered;  // its place in found_
  };

  void take(const record::Record& record) {
    const std::optional<Step> before = std::exchange(step_, std::nullopt);
    switch (WalKind(record.kind)) {
      case WalKind::kHead:
        if (run_.reads_all_) decode_head(record.payload);
        return;
      case WalKind::kEvent:
        if (run_.reads_all_ || file_.driver) take_event(record);
        return;
      case WalKind::kOutputs:
        take_outputs(record, before);
        return;
    }
    throw std::runtime_error("record kind " + std::to_string(record.kind) + " is not known");
  }

  void take_event(const record::Record& record) {
    const WalEvent e = decode_event(record.payload);
    if (e.event.kind == EventKind::kIo) received_ = e.event.bytes;
    if (!run_.reads_all_) return;
    step_ = Step{e.step, record.damaged, {}};
    if (e.event.kind == EventKind::kMessage &&
        add(e.event.channel, e.event.bytes, record.damaged ? Copy::kDoubtful : Copy::kReceived))
      step_->delivered = found_.size() - 1;
    if (e.event.kind != EventKind::kStart) return;
    const std::size_t n = std::size_t(std::max(e.event.incarnation, 0));
    if (n > kMaxIncarnations) return;
    if (n >= file_.starts.size()) file_.starts.resize(n + 1, kNever);
    file_.starts[n] = std::min(file_.starts[n], e.event.now.us);
  }

  // Outputs follow their event directly; damage of one is damage of the step.
  void take_outputs(const record::Record& record, const std::optional<Step>& event) {
    const WalOutputs o = decode_outputs(record.payload);
    const bool of_event = event && event->number == o.step;
    if (record.damaged && of_event && event->delivered) found_[*event->delivered].copy = Copy::kDoubtful;
    try {
      decode_output_list(o.body, outputs_);
    } catch (const std::runtime_error& e) {
      note("step", o.step, e.what());
      return;
    }
    const bool damaged = record.damaged || (of_event && event->damaged);
    for (const Output& output : outputs_) {
      if (output.kind == OutputKind::kWrite) sent_ = output.bytes;
      if (output.kind == OutputKind::kSend)
        add(output.channel, output.bytes, damaged ? Copy::kDoubtful : Copy::kSent);
    }
  }

  void note(const char* unit, std::uint64_t place, const std::string& what) {
    if (run_.reads_all_)
      file_.damage.push_back(file_.name + ", " + unit + " " + std::to_string(place) + ": " + what);
  }

  bool add(std::string_view name, std::span<const std::byte> bytes, Copy copy) {
    if (!run_.reads_all_ && !run_.wanted_.contains(name)) return false;
    const ChannelInfo* channel = find_channel(name);
    const auto stamp = channel ? stamp_of(bytes) : std::nullopt;
    if (!stamp) return false;
    found_.push_back({*stamp, number_, channel, bytes, number_, copy});
    return true;
  }

  RunReader& run_;
  std::size_t number_;
  File& file_;
  std::vector<Found>& found_;
  std::vector<Output> outputs_;
  std::optional<Step> step_;  // of the record before
  std::optional<std::span<const std::byte>> sent_, received_;
};

bool RunReader::find_new(std::vector<Found>& found) {
  if (reads_log_) {
    found = std::exchange(logged_, {});
    return !found.empty();
  }
  std::vector<std::vector<Found>> found_in(files_.size());
  const auto read = [&](std::size_t n) {
    map(files_[n]);
    Scan(*this, n, found_in[n]).go();
  };
  const bool look = folder_changed();
  bool grown = false;
  std::vector<std::size_t> large;
  for (std::size_t n = 0; n < files_.size(); ++n) {
    if ((!files_[n].map && !look) || !changed(files_[n])) continue;
    grown = true;
    if (std::uint64_t(files_[n].seen.st_size) > files_[n].from + kLargeBytes)
      large.push_back(n);
    else
      read(n);
  }
  if (!large.empty()) parallel_on(0)(int(large.size()), [&](int k) { read(large[std::size_t(k)]); });
  for (auto& some : found_in) {
    found.insert(found.end(), some.begin(), some.end());
    some = {};
  }
  return grown;
}

bool RunReader::poll(const Sink& sink) {
  std::vector<Found> found;
  if (reads_all_ || !find_new(found)) return false;
  std::ranges::stable_sort(found, {}, [](const Found& f) { return std::tuple(f.stamp.utime_us, f.rank); });
  std::vector<std::byte> changed;
  for (const Found& f : found) {
    const auto message = migration_.today(f.message, changed);
    const std::byte* const begin = files_[f.file].map->bytes().data();
    if (!validate(*f.channel, message))
      sink(f.channel->name, message,
           {f.file, std::uint64_t(f.message.data() - begin), std::uint32_t(f.message.size())});
  }
  forget_files();
  return true;
}

std::vector<std::byte> RunReader::read(const Place& place) {
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

std::vector<Exchange> RunReader::take_exchanges() {
  std::vector<Exchange> all;
  for (File& file : files_)
    if (std::exchange(file.exchanged, false)) all.push_back({file.node(), file.sent, file.received});
  return all;
}

const std::vector<std::span<const std::byte>>& RunReader::on(std::string_view channel) const {
  static const std::vector<std::span<const std::byte>> none;
  const ChannelInfo* row = find_channel(channel);
  return row && !by_channel_.empty() ? by_channel_[std::size_t(row - channel_table().data())] : none;
}

// Gives back the pages of files that are read forward, many of them at the same time: a page that is given
// back too early costs another fault.
class RunReader::PagesBehind {
 public:
  explicit PagesBehind(const std::vector<File>& files) : files_(files), from_(files.size(), 0) {}

  void passed(const Found& f) {
    const auto& map = files_[f.file].map;
    if (!map || !map->of_file()) return;
    const auto at = std::uint64_t(f.message.data() - map->bytes().data());
    std::uint64_t& from = from_[f.file];
    if (at >= from && at < from + kHeld_bytes) return;
    if (at > from) record::forget_pages(map->bytes(), from, at);
    from = at;
  }

 private:
  const std::vector<File>& files_;
  std::vector<std::uint64_t> from_;  // by file: what lies before is given back
};

// Of a message's copies the one that its publisher's file has is taken, else the first.
void RunReader::take_all() {
  std::vector<Found> found;
  find_new(found);
  std::vector<const Found*> best;
  for (const Found& f : found) best.push_back(&f);
  std::ranges::stable_sort(best, [](const Found* a, const Found* b) {
    return std::tuple(key_of(*a), a->copy != Copy::kSent) < std::tuple(key_of(*b), b->copy != Copy::kSent);
  });
  const auto repeated = std::unique(best.begin(), best.end(),
                                    [](const Found* a, const Found* b) { return key_of(*a) == key_of(*b); });
  best.erase(repeated, best.end());
  for (const File& file : files_) {
    damage_.insert(damage_.end(), file.damage.begin(), file.damage.end());
    if (starts_.size() < file.starts.size()) starts_.resize(file.starts.size(), kNever);
    for (std::size_t n = 0; n < file.starts.size(); ++n) starts_[n] = std::min(starts_[n], file.starts[n]);
  }
  // An incarnation that ended before its START begins where the next one does.
  for (std::size_t n = starts_.size(); n-- > 1;)
    if (starts_[n - 1] == kNever) starts_[n - 1] = starts_[n];
  compare_received(found, best);
  by_channel_.resize(channel_table().size());
  std::vector<std::byte> changed;
  PagesBehind behind(files_);
  for (const Found* f : best) {
    behind.passed(*f);
    const auto today = migration_.today(f->message, changed);
    by_channel_[std::size_t(f->channel - channel_table().data())].push_back(
        today.data() == f->message.data() ? f->message : migrated_.emplace_back(std::move(changed)));
  }
  forget_files();
}

void RunReader::forget_files() const {
  for (const File& file : files_)
    if (file.map) file.map->forget();
}

// A node writes a message to its file before the message leaves, so that no kill separates the two. A damaged
// file has lost messages. The launcher tells of a full disk, which its own file is on, nevertheless.
void RunReader::compare_received(const std::vector<Found>& found, const std::vector<const Found*>& best) {
  std::set<std::string> senders, damaged;  // whose file was read; and has lost something
  for (const File& file : files_) {
    if (file.map) senders.insert(file.node());
    if (!file.damage.empty()) damaged.insert(file.node());
  }
  std::set<Key> told;
  PagesBehind behind(files_);
  for (const Found& f : found) {
    const ChannelInfo& channel = *f.channel;
    const std::string publisher(info(channel.publisher).name);
    if (f.copy != Copy::kReceived || of_the_runner(channel) || !senders.contains(publisher)) continue;
    const Found& sent =
        **std::ranges::lower_bound(best, key_of(f), {}, [](const Found* b) { return key_of(*b); });
    const bool may_lack =
        damaged.contains(publisher) || (!sent_by_node(channel) && channel.name.starts_with("FAULT_"));
    behind.passed(f);
    behind.passed(sent);
    if (sent.copy == Copy::kSent ? same_bytes(sent.message, f.message) : may_lack) continue;
    if (!told.insert(key_of(f)).second) continue;
    forged_.push_back(std::string(channel.name) + " " + std::to_string(f.stamp.seq) + " of incarnation " +
                      std::to_string(f.stamp.incarnation) + ", received by " + files_[f.file].node() + ": " +
                      publisher + (sent.copy == Copy::kSent ? " sent other bytes" : " did not send it"));
  }
}

}  // namespace firn::runs
