#include "print/folder/run_commit.h"

#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "files/record/event_log.h"
#include "files/record/record_file.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "plant/record/record.h"
#include "print/folder/run_pack.h"
#include "runtime/write_ahead.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

fs::path commit_file(const fs::path& run) { return run / "world" / "commit"; }
fs::path state_file(const fs::path& run, std::uint64_t number) {
  return run / "world" / ("state-" + std::to_string(number));
}

// Names, relative to the run folder, of the files that grow while a print runs.
std::vector<std::string> growing_files(const fs::path& run) {
  std::vector<std::string> names;
  for (const char* name : {"log.lcm", "log.lcm.idx", "world.rec"})
    if (fs::exists(run / name)) names.push_back(name);
  for (const auto& entry : fs::directory_iterator(run / "nodes"))
    if (entry.path().extension() == ".wal") names.push_back("nodes/" + entry.path().filename().string());
  return names;
}

void remove_states(const fs::path& run, std::uint64_t but) {
  for (const auto& entry : fs::directory_iterator(run / "world")) {
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

// A full disk leaves half a head, or nothing; in a longer file any damage may be that of an event.
constexpr std::size_t kHeadOnly_bytes = 256 * 1024;

bool has_events(const fs::path& wal) {
  const logfile::MappedFile mapped(wal);
  logfile::RecordReader reader(mapped.bytes());
  while (const auto record = reader.next())
    if (record->damaged || record->kind != std::uint16_t(WalKind::kHead)) return true;
  return reader.damage().count() > 0 &&
         (reader.valid_end() > logfile::kRecordFileHeaderBytes || mapped.bytes().size() > kHeadOnly_bytes);
}

// Messages of the processes themselves; the nodes' own begin with the START.
bool before_start(std::string_view channel) {
  return channel.starts_with("CONFIG_") || channel.starts_with("HEARTBEAT_") ||
         channel == channels::kRunStart.name || channel == channels::fault(NodeId::kLauncher).name ||
         channel == channels::fault(NodeId::kRecorder).name;
}

bool log_tells(const fs::path& log) {
  if (!fs::exists(log)) return false;
  const logfile::EventLogFile file(log);
  logfile::EventLogReader reader = file.reader();
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
  save(run_ / "world" / "state");
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
    else if (fs::file_size(run / name) > length->second)
      fs::resize_file(run / name, length->second);
  }
  const fs::path state = run / "world" / "state", committed = state_file(run, commit.number);
  if (!commit.has_state)
    fs::remove(state);
  else if (fs::exists(committed))
    fs::rename(committed, state);
  else if (!fs::exists(state))
    throw std::runtime_error(committed.string() + ": the state of the world is missing");
  fs::remove(run / "result.json");
  fs::remove(commit_file(run));
  remove_states(run, 0);
  return true;
}

bool begin_anew(const fs::path& run) {
  for (const auto& entry : fs::directory_iterator(run / "nodes"))
    if (entry.path().extension() == ".wal" && has_events(entry.path())) return false;
  if (log_tells(run / "log.lcm") || world_acted(run / "world.rec")) return false;
  for (const std::string& name : growing_files(run)) fs::remove(run / name);
  for (const char* folder : {"nodes", "world"})
    for (const auto& entry : fs::directory_iterator(run / folder)) fs::remove(entry.path());
  fs::remove(run / "clocks");
  fs::remove_all(run / "seals");  // last: while one of the files is left, this is done again
  return true;
}

bool ready_to_resume(const fs::path& run) {
  expand_records(run);
  roll_back(run);
  return !begin_anew(run);
}

}  // namespace firn
