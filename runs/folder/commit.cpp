#include "runs/folder/commit.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "files/record/event_log.h"
#include "files/record/open_file.h"
#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "plant/record/record.h"
#include "runs/folder/pack.h"
#include "runtime/write_ahead.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

fs::path commit_file(const fs::path& run) { return RunPaths(run).world_path() / "commit"; }
fs::path state_file(const fs::path& run, std::uint64_t number) {
  return RunPaths(run).world_path() / ("state-" + std::to_string(number));
}

// Names, relative to the run folder, of the files that grow while a print runs.
std::vector<std::string> growing_files(const fs::path& run) {
  std::vector<std::string> names;
  const RunPaths paths(run);
  for (const fs::path& file :
       {paths.log_path(), record::index_path(paths.log_path()), paths.world_record_path()})
    if (fs::exists(file)) names.push_back(file.filename().string());
  for (const fs::path& file : paths.wal_files()) names.push_back(RunPaths::wal_name(file.stem().string()));
  return names;
}

void remove_states(const fs::path& run, std::uint64_t but) {
  for (const auto& entry : fs::directory_iterator(RunPaths(run).world_path())) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("state-") && entry.path() != state_file(run, but)) fs::remove(entry.path());
  }
}

struct Commit {
  std::uint64_t number = 0;
  bool has_state = false;
  std::map<std::string, std::uint64_t> lengths;
};

Commit read_commit(const fs::path& run) {
  const fs::path file = commit_file(run);
  std::istringstream in(read_file(file));
  Commit c;
  std::string word, name;
  std::uint64_t length = 0;
  if (!(in >> word >> c.number >> c.has_state) || word != "commit")
    throw std::runtime_error(file.string() + ": is no commit of a run");
  while (in >> length >> name) c.lengths[name] = length;
  if (!in.eof()) throw std::runtime_error(file.string() + ": a length and a name are wanted in each line");
  return c;
}

// Takes the bytes behind `length` from a file that has more.
void cut(const fs::path& file, std::uint64_t length) {
  const record::OpenedFile opened = record::open_file(file, O_RDWR);
  if (opened.fd < 0)
    throw record::FileError(file, length, opened.what ? opened.what : "cannot open", opened.error);
  struct stat s {};
  const bool done = ::fstat(opened.fd, &s) == 0 &&
                    (std::uint64_t(s.st_size) <= length || ::ftruncate(opened.fd, off_t(length)) == 0);
  const int error = errno;
  ::close(opened.fd);
  if (!done) throw record::FileError(file, length, "cannot truncate", error);
}

// A full disk leaves half a head, or nothing; in a longer file any damage may be that of an event.
constexpr std::size_t kHeadOnly_bytes = 256 * 1024;

bool has_events(const fs::path& wal) {
  const record::MappedFile mapped(wal);
  record::RecordReader reader(mapped.bytes());
  while (const auto record = reader.next())
    if (record->damaged || record->kind != std::uint16_t(WalKind::kHead)) return true;
  return reader.damage().count() > 0 &&
         (reader.valid_end() > record::kRecordFileHeaderBytes || mapped.bytes().size() > kHeadOnly_bytes);
}

// Messages of the processes themselves; the nodes' own begin with the START.
bool before_start(std::string_view channel) {
  return channel.starts_with("CONFIG_") || channel.starts_with("HEARTBEAT_") ||
         channel == channels::kRunStart.name || channel == channels::fault(NodeId::kLauncher).name ||
         channel == channels::fault(NodeId::kRecorder).name;
}

bool log_tells(const fs::path& log) {
  if (!fs::exists(log)) return false;
  const record::EventLogFile file(log);
  record::EventLogReader reader = file.reader();
  while (const auto event = reader.next())
    if (event->damaged || !before_start(event->channel)) return true;
  return reader.damage().count() > 0 && file.bytes().size() > kHeadOnly_bytes;
}

bool world_acted(const fs::path& record) {
  if (!fs::exists(record)) return false;
  const plant::WorldHistory h = plant::read_history(record);
  return !h.shots.empty() || !h.firings.empty() || !h.lamp.empty() || !h.scans.empty();
}

}  // namespace

void RunCommit::commit(const std::function<void(const fs::path&)>& save) {
  const std::uint64_t number = number_ + 1;
  if (save) save(state_file(run_, number));
  std::string text = "commit " + std::to_string(number) + " " + (save ? "1" : "0") + "\n";
  for (const std::string& name : growing_files(run_))
    text += std::to_string(fs::file_size(run_ / name)) + " " + name + "\n";
  write_file_atomically(commit_file(run_), text);
  number_ = number;
  remove_states(run_, number);
}

void RunCommit::end(const std::function<void(const fs::path&)>& save) {
  save(RunPaths(run_).world_state_path());
  fs::remove(commit_file(run_));
  remove_states(run_, 0);
}

bool roll_back(const fs::path& run) {
  if (!fs::exists(commit_file(run))) return false;
  const Commit commit = read_commit(run);
  for (const std::string& name : growing_files(run)) {
    const auto length = commit.lengths.find(name);
    if (length == commit.lengths.end())
      fs::remove(run / name);
    else
      cut(run / name, length->second);
  }
  const fs::path state = RunPaths(run).world_state_path(), committed = state_file(run, commit.number);
  if (!commit.has_state)
    fs::remove(state);
  else if (fs::exists(committed))
    fs::rename(committed, state);
  else if (!fs::exists(state))
    throw std::runtime_error(committed.string() + ": the state of the world is missing");
  fs::remove(RunPaths(run).result_path());
  fs::remove(commit_file(run));
  remove_states(run, 0);
  return true;
}

bool begin_anew(const fs::path& run) {
  const RunPaths paths(run);
  if (std::ranges::any_of(paths.wal_files(), has_events)) return false;
  if (log_tells(paths.log_path()) || world_acted(paths.world_record_path())) return false;
  for (const std::string& name : growing_files(run)) fs::remove(run / name);
  for (const fs::path& folder : {paths.nodes_path(), paths.world_path()})
    for (const auto& entry : fs::directory_iterator(folder)) fs::remove(entry.path());
  fs::remove(paths.clocks_path());
  fs::remove_all(paths.seals_path());  // last: while one of the files is left, this is done again
  return true;
}

bool ready_to_resume(const fs::path& run) {
  expand_records(run);
  roll_back(run);
  return !begin_anew(run);
}

}  // namespace firn::runs
