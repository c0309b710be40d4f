#include "print/operator/print_queue.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "config/include.h"
#include "files/digest.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "files/utc_time.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using QueueJson = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr auto kLockPause = std::chrono::milliseconds(20);
constexpr int kLockPauses = 250;  // 5 s

// @returns -1 and errno: it cannot be opened
int open_lock(const fs::path& file) {
  std::error_code ignored;  // open() tells
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);
  return ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR);
}

fs::path beside(const fs::path& file, const char* extension) {
  fs::path other = file;
  return other.replace_extension(extension);
}

QueueJson to_json(const QueuedPrint& p) {
  return {{"id", p.id},
          {"experiment", p.experiment},
          {"digest", p.digest},
          {"set", p.overrides},
          {"meta", p.meta},
          {"accept_bringup", p.accept_bringup},
          {"bus", p.bus},
          {"tolerance_um", p.tolerance_um},
          {"by", p.by},
          {"added_utc", p.added_utc},
          {"began_utc", p.began_utc},
          {"run", p.run},
          {"why", p.why}};
}

QueuedPrint queued_print(const QueueJson& j) {
  QueuedPrint p;
  j.at("id").get_to(p.id);
  j.at("experiment").get_to(p.experiment);
  j.at("digest").get_to(p.digest);
  j.at("set").get_to(p.overrides);
  j.at("meta").get_to(p.meta);
  j.at("accept_bringup").get_to(p.accept_bringup);
  j.at("bus").get_to(p.bus);
  j.at("tolerance_um").get_to(p.tolerance_um);
  j.at("by").get_to(p.by);
  j.at("added_utc").get_to(p.added_utc);
  j.at("began_utc").get_to(p.began_utc);
  j.at("run").get_to(p.run);
  j.at("why").get_to(p.why);
  return p;
}

}  // namespace

std::int64_t PrintQueue::add(QueuedPrint print, bool first) {
  if (prints.size() >= kMaxQueued)
    throw UsageError("the queue holds " + std::to_string(kMaxQueued) + " prints, which is the most");
  print.id = next_id++;
  print.added_utc = utc_now();
  const auto waits = std::ranges::find_if(prints, [](const QueuedPrint& p) { return p.began_utc.empty(); });
  return prints.insert(first ? waits : prints.end(), std::move(print))->id;
}

QueuedPrint* PrintQueue::find(std::int64_t id) {
  const auto at = std::ranges::find(prints, id, &QueuedPrint::id);
  return at == prints.end() ? nullptr : &*at;
}

bool PrintQueue::remove(std::int64_t id) {
  return std::erase_if(prints, [&](const QueuedPrint& p) { return p.id == id; }) > 0;
}

void PrintQueue::clear(const std::string& by) {
  cleared_by = by;
  cleared_utc = utc_now();
}

bool PrintQueue::begin(std::int64_t id) {
  if (prints.empty() || prints.front().id != id) return false;
  cleared_by.clear();
  cleared_utc.clear();
  prints.front().began_utc = utc_now();
  return true;
}

void PrintQueue::put_back(std::int64_t id, const std::string& by) {
  clear(by);
  if (QueuedPrint* const p = find(id)) p->began_utc.clear();
}

void PrintQueue::end(std::int64_t id, const std::string& run, const std::string& why) {
  if (why.empty()) {
    remove(id);
  } else if (QueuedPrint* const p = find(id)) {
    p->run = run;
    p->why = why;
  }
}

fs::path queue_file(const fs::path& runs) { return runs / "queue.json"; }

PrintQueue read_queue(const fs::path& file) {
  return fs::exists(file) ? parse_queue(read_file(file), file.string()) : PrintQueue();
}

PrintQueue parse_queue(const std::string& text, const std::string& name) {
  PrintQueue q;
  try {
    const QueueJson j = QueueJson::parse(text);
    if (j.at("version").get<int>() != kVersion)
      throw UsageError(name + ": a queue of version " + j.at("version").dump() +
                       "; this program knows version " + std::to_string(kVersion));
    j.at("next_id").get_to(q.next_id);
    j.at("cleared_by").get_to(q.cleared_by);
    j.at("cleared_utc").get_to(q.cleared_utc);
    for (const QueueJson& p : j.at("prints")) q.prints.push_back(queued_print(p));
  } catch (const QueueJson::exception& e) {
    throw UsageError(name + ": is no queue of prints: " + e.what());
  }
  return q;
}

QueueChange::QueueChange(const fs::path& file) : file_(file) {
  const fs::path lock = beside(file, ".lock");
  lock_ = open_lock(lock);
  if (lock_ < 0) throw UsageError(lock.string() + ": cannot be written: " + std::strerror(errno));
  for (int n = 0; ::flock(lock_, LOCK_EX | LOCK_NB) != 0; ++n) {
    if (n == kLockPauses) {
      ::close(lock_);
      throw UsageError(file.string() + ": another command has been changing it for 5 s");
    }
    std::this_thread::sleep_for(kLockPause);
  }
  try {
    queue = read_queue(file);
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

QueueChange::~QueueChange() { ::close(lock_); }

std::string to_text(const PrintQueue& queue) {
  QueueJson prints = QueueJson::array();
  for (const QueuedPrint& p : queue.prints) prints.push_back(to_json(p));
  const QueueJson j{{"version", kVersion},
                    {"next_id", queue.next_id},
                    {"cleared_by", queue.cleared_by},
                    {"cleared_utc", queue.cleared_utc},
                    {"prints", prints}};
  return j.dump(2, ' ', false, QueueJson::error_handler_t::replace) + "\n";
}

void QueueChange::save() const { write_file_atomically(file_, to_text(queue)); }

QueueTurn::QueueTurn(const fs::path& file) {
  const fs::path lock = beside(file, ".turn");
  lock_ = open_lock(lock);
  if (lock_ < 0) throw UsageError(lock.string() + ": cannot be written: " + std::strerror(errno));
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_);
    throw UsageError(file.string() + ": firn queue start works on it already (pid " + read_file(lock) + ")");
  }
  const std::string pid = std::to_string(::getpid());
  if (::ftruncate(lock_, 0) != 0 || ::pwrite(lock_, pid.data(), pid.size(), 0) != ssize_t(pid.size())) {
    const int error = errno;
    ::close(lock_);
    throw UsageError(lock.string() + ": cannot be written: " + std::strerror(error));
  }
}

QueueTurn::~QueueTurn() { ::close(lock_); }

std::string experiment_digest(const fs::path& experiment) {
  std::string all;
  for (const auto& [name, text] : read_with_includes(experiment)) {
    all += fs::path(name).filename().string();
    all += '\0';
    all += text;
    all += '\0';
  }
  return sha256_hex(std::as_bytes(std::span(all)));
}

}  // namespace firn
