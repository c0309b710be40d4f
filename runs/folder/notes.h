// Notes, tags and acknowledged alarms of a run, as people write them during a print and after it:
// RUN/notes.jsonl, a line of JSON for each, which is only ever added to. The next seal covers them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace firn::runs {

struct NoteEntry {
  enum class Kind : std::uint8_t { kNote, kTag, kUntag, kAck };
  Kind kind = Kind::kNote;
  std::string text;      ///< of a tag its name, of an acknowledgement the alarm
  std::string author;    ///< empty: an older program kept none
  std::string time_utc;  ///< "2026-11-30T12:00:00Z"; empty as above
  std::string host;
};

inline constexpr std::size_t kMaxNoteBytes = 16384, kMaxTags = 32, kMaxTagBytes = 64, kMaxAuthorBytes = 100;

struct RunNotes {
  std::vector<NoteEntry> entries;  ///< oldest first
  int unreadable = 0;              ///< lines

  std::vector<std::string> tags() const;        ///< that were set and not taken away since
  std::vector<NoteEntry> notes() const;         ///< without tags and alarms, oldest first
  std::vector<NoteEntry> acknowledged() const;  ///< of each alarm the first acknowledgement
};

/// Reads RUN/notes.jsonl, and RUN/notes.json as Firn 0.1 wrote it. A run without notes has none, and lines
/// that cannot be read are counted.
RunNotes read_notes(const std::filesystem::path& run);

/// Adds entries, all or none. Tags that the run has already, and tags to take away that it has not, are left
/// out, and so are alarms that somebody acknowledged before. Author, time and host are filled in where they
/// are empty: the user of this process, now, here.
/// @throws UsageError naming the limit that is broken, or that somebody writes notes; WriteError
void add_notes(const std::filesystem::path& run, std::vector<NoteEntry> entries);

/// Returns "note", "tag", "untag" or "ack".
std::string_view note_kind_word(NoteEntry::Kind kind);

/// Returns the name of this process's user.
std::string user_name();

}  // namespace firn::runs
