#include "runs/folder/seal_check.h"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "core/options/number.h"
#include "files/json.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/trial_files.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

// Of whatever kind, also where a link on the way leads nowhere.
bool is_there(const fs::path& file) {
  std::error_code unreadable;
  return fs::symlink_status(file, unreadable).type() != fs::file_type::not_found;
}

enum class Kind {
  kFixed,    // never changes
  kGrowing,  // bytes are only added
  kMutable,  // written anew while an incarnation runs
};

bool in(const char* folder, const std::string& path) { return path.starts_with(std::string(folder) + "/"); }

Kind kind_of(const std::string& path) {
  if (path == RunPaths::kExperiment || path == RunPaths::kProvenance || path == RunPaths::kSourcesDiff ||
      in(RunPaths::kInputs, path))
    return Kind::kFixed;
  const bool node = in(RunPaths::kNodes, path) && RunPaths::is_sent_record(path);
  return node || path == RunPaths::kWorldRecord || path == RunPaths::kClocks || path == RunPaths::kNotes
             ? Kind::kGrowing
             : Kind::kMutable;
}

std::string seal_name(const std::string& file) { return std::string(RunPaths::kSeals) + "/" + file; }

// Files that Firn reads from a run folder. The others are made from these, or are the user's.
bool is_sealed(const std::string& path) {
  if (path == RunPaths::kInstrumentsLock || is_trial_file(path)) return false;
  for (const char* folder :
       {RunPaths::kInputs, RunPaths::kNodes, RunPaths::kWorld, RunPaths::kPorts, RunPaths::kHosts})
    if (in(folder, path)) return true;
  for (const char* file : {RunPaths::kExperiment, RunPaths::kProvenance, RunPaths::kSourcesDiff,
                           RunPaths::kResult, RunPaths::kClocks, RunPaths::kNotes})
    if (path == file) return true;
  return path.starts_with(RunPaths::kLog) || path.starts_with(RunPaths::kWorldRecord);
}

std::vector<std::string> sealed_files(const fs::path& run) {
  std::vector<std::string> paths;
  for (auto it = fs::recursive_directory_iterator(run); it != fs::recursive_directory_iterator(); ++it) {
    const std::string path = it->path().lexically_relative(run).generic_string();
    if (is_sealed(path) && it->symlink_status().type() == fs::file_type::regular) paths.push_back(path);
  }
  std::ranges::sort(paths);
  return paths;
}

bool promises_seals(const fs::path& run) {
  try {
    return nlohmann::json::parse(read_file(RunPaths(run).provenance_path())).value("sealed", false);
  } catch (const std::exception&) {
    return false;
  }
}

// Holds the content of a file by the seals whose digest of it must still hold.
struct History {
  std::vector<std::pair<std::int64_t, SealedFile>> sealed;  // number of the seal
};

class Check {
 public:
  Check(const fs::path& run, bool sync) : run_(run), sync_(sync) {}

  SealCheck go() {
    read_seals();
    if (c_.seals.empty()) {
      if (c_.differs.empty() && promises_seals(run_))
        differs(RunPaths::kSeals, 0, 0,
                "the folder is missing or empty, though the run was sealed when it began");
      c_.notes.push_back("no seal: changes of files cannot be seen");
    } else {
      newest_ = &c_.seals.back();
      gather_past();
      gather_histories();
    }
    for (const std::string& path : sealed_files(run_)) check_file(path);
    for (const auto& [path, history] : histories_) check_missing(path);
    return std::move(c_);
  }

 private:
  void differs(const std::string& file, std::uint64_t from, std::uint64_t to, const std::string& what) {
    c_.differs.push_back({file, from, to, what});
  }

  void read_seals() {
    std::set<std::int64_t> numbers;
    const fs::path seals = RunPaths(run_).seals_path();
    if (fs::is_directory(seals))
      for (const auto& entry : fs::directory_iterator(seals)) {
        const std::string name = entry.path().filename().string();
        const std::string digits = name.substr(0, name.find('.'));
        const std::optional<std::int64_t> number = whole_number<std::int64_t>(digits, 0, 999'999'999);
        if (number && name == std::to_string(*number) + ".seal")
          numbers.insert(*number);
        else if (name == kDerivedSeal)
          check_derived(entry.path());
        else if (!name.ends_with(".part"))  // of a seal that was never finished
          differs(seal_name(name), 0, 0, "is no seal");
      }
    std::int64_t wanted = 0;
    for (const std::int64_t n : numbers) {
      for (; wanted < n; ++wanted) differs(seal_name(std::to_string(wanted) + ".seal"), 0, 0, "is missing");
      ++wanted;
      read_seal(n);
    }
  }

  void read_seal(std::int64_t n) {
    const std::string name = seal_name(std::to_string(n) + ".seal");
    try {
      Seal s = decode_seal(read_file(run_ / name));
      if (s.number != n) throw std::runtime_error("holds seal " + std::to_string(s.number));
      const bool follows = !c_.seals.empty() && c_.seals.back().number == n - 1;
      if (follows ? s.before != c_.seals.back().digest : n == 0 && !s.before.empty())
        differs(name, 0, 0, "does not follow the seal before: another digest");
      c_.seals.push_back(std::move(s));
    } catch (const std::runtime_error& e) {
      differs(name, 0, 0, e.what());
    }
  }

  // These files may be removed or made again at any time.
  void check_derived(const fs::path& seal) {
    try {
      for (const SealedFile& f : decode_seal(read_file(seal)).files)
        if (is_there(run_ / f.path) && digest_file(run_ / f.path, {}).sha256 != f.sha256)
          c_.derived.push_back({f.path, 0, f.bytes, "is not what was made from the run"});
    } catch (const std::runtime_error& e) {
      c_.derived.push_back({seal_name(kDerivedSeal), 0, 0, e.what()});
    }
  }

  void gather_past() {
    const Seal* before = nullptr;
    for (const Seal& s : c_.seals) {
      for (const std::string& d : s.differs) c_.past_differs.push_back(d);
      if (before && before->open && s.open)
        c_.notes.push_back("incarnation " + std::to_string(before->incarnation) +
                           " was not sealed at its end, but as found when the next one began");
      if (!s.open && s.reason.ends_with(kAsFound))
        c_.notes.push_back("the end of incarnation " + std::to_string(s.incarnation) +
                           " was sealed later, as found");
      before = &s;
    }
    if (newest_->open)
      c_.notes.push_back("not sealed since incarnation " + std::to_string(newest_->incarnation) + " began");
  }

  void gather_histories() {
    for (const Seal& s : c_.seals) {
      for (const SealedFile& f : s.files) {
        if (is_trial_file(f.path)) continue;  // Firn 0.1 sealed what a kill had left
        History& h = histories_[f.path];
        if (f.anew) h.sealed.clear();
        h.sealed.emplace_back(s.number, f);
      }
    }
    // A file that the newest seal lacks was gone by then, and that seal says so.
    std::erase_if(histories_, [&](const auto& h) { return h.second.sealed.back().first != newest_->number; });
  }

  void check_file(const std::string& path) {
    seen_.insert(path);
    const auto found = histories_.find(path);
    const History none, &history = found == histories_.end() ? none : found->second;
    std::vector<std::uint64_t> lengths;
    for (const auto& [number, f] : history.sealed) lengths.push_back(f.bytes);
    std::ranges::sort(lengths);
    const FileDigests d = digest_file(run_ / path, lengths, sync_);
    const auto prefix = [&](std::uint64_t bytes) {
      const auto at = std::ranges::find(lengths, bytes);
      return d.prefixes[std::size_t(at - lengths.begin())];
    };
    SealedFile now{path, d.bytes, d.sha256, false};
    now.anew = history.sealed.empty() ||
               prefix(history.sealed.back().second.bytes) != history.sealed.back().second.sha256;
    c_.files.push_back(now);
    if (!newest_) return;
    if (history.sealed.empty()) return check_added(path);
    const Kind kind = kind_of(path);
    if (newest_->open && kind == Kind::kMutable) return check_result(path, now.anew);
    std::uint64_t whole = 0;
    for (const auto& [number, f] : history.sealed) {
      if (prefix(f.bytes) == f.sha256) {
        whole = f.bytes;
        continue;
      }
      if (newest_->open && kind == Kind::kGrowing && torn(f)) continue;
      return tell_change(number, f, whole, d.bytes);
    }
    if (d.bytes > whole && path == RunPaths::kNotes) return tell_new_notes();
    if (d.bytes > whole && !(newest_->open && kind == Kind::kGrowing))
      differs(path, whole, d.bytes,
              "bytes " + std::to_string(whole) + " to " + std::to_string(d.bytes) +
                  " were added after seal " + std::to_string(newest_->number));
  }

  void tell_change(std::int64_t number, const SealedFile& f, std::uint64_t whole, std::uint64_t bytes) {
    if (bytes < f.bytes)
      differs(f.path, bytes, f.bytes,
              "has " + std::to_string(bytes) + " bytes, seal " + std::to_string(number) + " has " +
                  std::to_string(f.bytes));
    else
      differs(f.path, whole, f.bytes,
              "bytes " + std::to_string(whole) + " to " + std::to_string(f.bytes) +
                  " are not those of seal " + std::to_string(number));
  }

  // The rest of a torn write was moved away when the file was opened again.
  bool torn(const SealedFile& f) const {
    for (int n = 1;; ++n) {
      const fs::path tail = run_ / (f.path + ".torn-" + std::to_string(n));
      if (!fs::is_regular_file(tail)) return false;
      if (restores(run_ / f.path, tail, f)) return true;
    }
  }

  // People add notes at any time.
  void tell_new_notes() {
    if (!newest_->open)
      c_.notes.push_back("notes were added after seal " + std::to_string(newest_->number) +
                         ": the next seal covers them");
  }

  void check_added(const std::string& path) {
    if (path == RunPaths::kNotes) return tell_new_notes();
    if (!newest_->open || kind_of(path) == Kind::kFixed)
      differs(path, 0, 0, "was added after seal " + std::to_string(newest_->number));
    else
      check_result(path, true);
  }

  // A resume removes the result before anything else, and the last seal follows the result.
  void check_result(const std::string& path, bool anew) {
    if (path == RunPaths::kResult && anew)
      differs(path, 0, 0, "says that the run ended, and the seal of that end is missing");
  }

  void check_missing(const std::string& path) {
    if (seen_.contains(path) || (newest_->open && kind_of(path) == Kind::kMutable)) return;
    differs(path, 0, 0,
            std::string(is_there(run_ / path) ? "is no regular file" : "is missing") + ", seal " +
                std::to_string(newest_->number) + " has it");
  }

  const fs::path& run_;
  bool sync_;
  SealCheck c_;
  const Seal* newest_ = nullptr;
  std::map<std::string, History> histories_;
  std::set<std::string> seen_;
};

}  // namespace

std::string to_text(const SealDifference& d) { return d.file + ": " + d.what; }

std::string SealCheck::summary() const {
  if (seals.empty()) return "not sealed";
  return "sealed: " + std::to_string(seals.size()) + " seals, " + std::to_string(seals.back().files.size()) +
         " files, " + seals.back().digest;
}

std::vector<std::string> SealCheck::lines() const {
  std::vector<std::string> all;
  for (const SealDifference& d : differs) all.push_back(to_text(d));
  all.insert(all.end(), past_differs.begin(), past_differs.end());
  return all;
}

SealCheck check_seals(const fs::path& run, bool sync) try {
  if (!fs::is_directory(run)) throw UsageError(run.string() + ": is no run folder (no such directory)");
  return Check(run, sync).go();
} catch (const fs::filesystem_error& e) {
  throw record::FileError(e.path1(), 0, "cannot be read", e.code().value());
}

std::vector<std::string> require_seals(const fs::path& run, bool unsealed) {
  const SealCheck c = check_seals(run);
  std::vector<std::string> lines = c.lines();
  if (!lines.empty() && !unsealed)
    throw UsageError(run.string() + ": is not as it was sealed: " + lines.front() +
                     (lines.size() > 1 ? " (and " + std::to_string(lines.size() - 1) + " more)" : "") +
                     "; --unsealed uses it nevertheless");
  lines.insert(lines.end(), c.notes.begin(), c.notes.end());
  return lines;
}

}  // namespace firn::runs
