#include "runs/folder/notes.h"

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <optional>

#include "core/options/enumerators.h"
#include "files/json.h"
#include "files/record/open_file.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/trimmed.h"
#include "files/usage_error.h"
#include "runs/folder/run_lock.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;
using NoteJson = nlohmann::ordered_json;
using NoteKind = NoteEntry::Kind;

constexpr const char* kNoteKinds[] = {"note", "tag", "untag", "ack"};
static_assert(std::size(kNoteKinds) == kTableSize<NoteKind>);

std::string note_time() {
  const std::time_t t = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm tm{};
  gmtime_r(&t, &tm);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &tm);
  return text;
}

std::string note_host() {
  utsname host{};
  return uname(&host) == 0 ? host.nodename : "?";
}

void check_note(const std::string& what, const std::string& text, std::size_t most, bool lines) {
  if (text.empty()) throw UsageError(what + " must not be empty");
  if (text.size() > most)
    throw UsageError(what + " has " + std::to_string(text.size()) + " bytes; at most " +
                     std::to_string(most));
  for (const unsigned char c : text)
    if ((c < 0x20 && !(lines && (c == '\n' || c == '\t'))) || c == 0x7f)
      throw UsageError(what + " must not have control characters");
}

std::optional<NoteEntry> parse_note(std::string_view line) {
  const NoteJson j = NoteJson::parse(line.begin(), line.end(), nullptr, false);
  if (!j.is_object()) return std::nullopt;
  const auto text = [&](const char* key) {
    const auto at = j.find(key);
    return at != j.end() && at->is_string() ? at->get<std::string>() : std::string();
  };
  const std::string word = text("kind");
  const auto kind = std::ranges::find(kNoteKinds, word);
  if (kind == std::end(kNoteKinds) || text("text").empty()) return std::nullopt;
  return NoteEntry{NoteKind(kind - std::begin(kNoteKinds)), text("text"), text("author"), text("time_utc"),
                   text("host")};
}

std::string notes_text(const fs::path& file) { return fs::exists(file) ? read_file(file) : std::string(); }

// {"tags": [...], "note": "..."}, without author and time.
void read_old_notes(const fs::path& run, RunNotes& notes) {
  const std::string text = notes_text(RunPaths(run).old_notes_path());
  if (text.empty()) return;
  const NoteJson j = NoteJson::parse(text, nullptr, false);
  if (!j.is_object()) {
    ++notes.unreadable;
    return;
  }
  if (const auto tags = j.find("tags"); tags != j.end() && tags->is_array())
    for (const NoteJson& tag : *tags)
      if (tag.is_string()) notes.entries.push_back({NoteKind::kTag, tag.get<std::string>(), {}, {}, {}});
  if (const auto note = j.find("note");
      note != j.end() && note->is_string() && !note->get<std::string>().empty())
    notes.entries.push_back({NoteKind::kNote, note->get<std::string>(), {}, {}, {}});
}

std::string note_line(const NoteEntry& e) try {
  return NoteJson{{"time_utc", e.time_utc},
                  {"author", e.author},
                  {"host", e.host},
                  {"kind", std::string(note_kind_word(e.kind))},
                  {"text", e.text}}
             .dump() +
         "\n";
} catch (const NoteJson::type_error&) {
  throw UsageError("a note, a tag or its author is no UTF-8");
}

// One write, so that a kill leaves all lines or a torn one, which the next addition ends.
void append_notes(const fs::path& file, std::string lines) {
  const auto fail = [&](const char* what, int error) {
    throw WriteError(file.string() + ": " + what + ": " + std::strerror(error));
  };
  const record::OpenedFile opened = record::open_file(file, O_RDWR | O_APPEND | O_CREAT);
  if (opened.what) throw WriteError(file.string() + ": " + opened.what);
  const int fd = opened.fd;
  if (fd < 0) fail("cannot be opened", opened.error);
  struct stat before {};
  int error = ::fstat(fd, &before) == 0 ? 0 : errno;
  char last = '\n';
  if (!error && before.st_size > 0 && ::pread(fd, &last, 1, before.st_size - 1) != 1) error = EIO;
  if (last != '\n') lines.insert(0, "\n");
  if (!error) {
    const ssize_t n = ::write(fd, lines.data(), lines.size());
    error = n < 0 ? errno : n != ssize_t(lines.size()) ? ENOSPC : ::fdatasync(fd) != 0 ? errno : 0;
    if (error && ::ftruncate(fd, before.st_size) != 0) error = errno;
  }
  ::close(fd);
  if (error) fail("cannot be written", error);
}

}  // namespace

std::vector<std::string> RunNotes::tags() const {
  std::vector<std::string> set;
  for (const NoteEntry& e : entries) {
    if (e.kind != NoteKind::kTag && e.kind != NoteKind::kUntag) continue;
    std::erase(set, e.text);
    if (e.kind == NoteKind::kTag) set.push_back(e.text);
  }
  return set;
}

std::vector<NoteEntry> RunNotes::notes() const {
  std::vector<NoteEntry> all = entries;
  std::erase_if(all, [](const NoteEntry& e) { return e.kind != NoteKind::kNote; });
  return all;
}

std::vector<NoteEntry> RunNotes::acknowledged() const {
  std::vector<NoteEntry> first;
  for (const NoteEntry& e : entries)
    if (e.kind == NoteKind::kAck && std::ranges::find(first, e.text, &NoteEntry::text) == first.end())
      first.push_back(e);
  return first;
}

RunNotes read_notes(const fs::path& run) {
  RunNotes notes;
  try {
    read_old_notes(run, notes);
    const std::string text = notes_text(RunPaths(run).notes_path());
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const std::string_view line = std::string_view(text).substr(at, end - at);
      at = end + 1;
      if (line.empty()) continue;
      if (auto entry = parse_note(line))
        notes.entries.push_back(std::move(*entry));
      else
        ++notes.unreadable;
    }
  } catch (const std::exception&) {  // no file that can be read, as a link
    ++notes.unreadable;
  }
  return notes;
}

void add_notes(const fs::path& run, std::vector<NoteEntry> entries) {
  const std::string now = note_time();
  for (NoteEntry& e : entries) {
    e.text = trimmed(e.text);
    e.author = e.author.empty() ? user_name() : std::string(trimmed(e.author));
    if (e.time_utc.empty()) e.time_utc = now;
    if (e.host.empty()) e.host = note_host();
    if (e.kind == NoteKind::kNote)
      check_note("a note", e.text, kMaxNoteBytes, true);
    else if (e.kind == NoteKind::kAck)
      check_note("an alarm", e.text, kMaxNoteBytes, false);
    else
      check_note("a tag", e.text, kMaxTagBytes, false);
    check_note("the author of a note", e.author, kMaxAuthorBytes, false);
  }
  const RunLock lock(run, RunUse::kNote);
  const RunNotes before = read_notes(run);
  std::vector<std::string> tags = before.tags();
  std::vector<NoteEntry> acknowledged = before.acknowledged();
  std::string lines;
  for (const NoteEntry& e : entries) {
    if (e.kind == NoteKind::kAck) {
      if (std::ranges::find(acknowledged, e.text, &NoteEntry::text) == acknowledged.end())
        lines += note_line(e);
      acknowledged.push_back(e);
      continue;
    }
    const bool is_set = std::ranges::find(tags, e.text) != tags.end();
    if ((e.kind == NoteKind::kTag && is_set) || (e.kind == NoteKind::kUntag && !is_set)) continue;
    if (e.kind == NoteKind::kUntag) std::erase(tags, e.text);
    if (e.kind == NoteKind::kTag) tags.push_back(e.text);
    lines += note_line(e);
  }
  if (tags.size() > kMaxTags)
    throw UsageError(run.string() + ": a run has at most " + std::to_string(kMaxTags) + " tags");
  if (!lines.empty()) append_notes(RunPaths(run).notes_path(), std::move(lines));
}

std::string_view note_kind_word(NoteEntry::Kind kind) { return kNoteKinds[std::size_t(kind)]; }

std::string user_name() {
  const passwd* user = ::getpwuid(::geteuid());
  return user && user->pw_name && *user->pw_name ? user->pw_name : "uid " + std::to_string(::geteuid());
}

}  // namespace firn::runs
