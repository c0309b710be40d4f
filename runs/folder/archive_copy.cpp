#include "runs/folder/archive_copy.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "files/command.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/seal_check.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

ArchiveCopy left_out(const std::string& why) { return {ArchiveCopy::State::kLeftOut, why, ""}; }

// The newest seal of a folder without a look at the files that it covers; nothing: there is none to read.
std::optional<Seal> newest_seal(const fs::path& run) {
  std::optional<Seal> newest;
  for (std::int64_t n = 0;; ++n) {
    const fs::path file = RunPaths(run).seals_path() / (std::to_string(n) + ".seal");
    if (!fs::exists(file)) return newest;
    try {
      newest = decode_seal(read_file(file));
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }
}

std::uintmax_t notes_size(const fs::path& run) {
  std::error_code missing;
  const std::uintmax_t size = fs::file_size(RunPaths(run).notes_path(), missing);
  return missing ? 0 : size;
}

std::uintmax_t sealed_notes_size(const Seal& seal) {
  const auto at = std::ranges::find(seal.files, RunPaths::kNotes, &SealedFile::path);
  return at == seal.files.end() ? 0 : at->bytes;
}

// Waits for nobody: a run in use is copied the next time.
void seal_its_notes(const fs::path& run) {
  const RunLock lock(run, RunUse::kWrite);
  seal_notes(run);
}

}  // namespace

// Files of a lock and unfinished ones stay; links, pipes and devices are none of a run's.
std::string rsync_run(const std::vector<std::string>& how, const std::string& from, const std::string& to,
                      const std::atomic<bool>* stop) {
  std::vector<std::string> words{"rsync",
                                 "-rtp",
                                 "--partial",
                                 "--delete",
                                 "--exclude=/lock",
                                 "--exclude=/io/lock",
                                 "--exclude=*.part",
                                 "--exclude=/operator"};
  words.insert(words.end(), how.begin(), how.end());
  words.insert(words.end(), {"--", from, to});
  const CommandEnd end = run_command(std::move(words), stop);
  if (end.missing()) throw UsageError("rsync is not installed: apt install rsync");
  if (end.code != 0) throw std::runtime_error(from + ": rsync: " + end.reason());
  return end.output;
}

FolderArchive::FolderArchive(const fs::path& archive) : archive_(fs::absolute(archive)) {
  std::error_code error;
  fs::create_directories(archive, error);
  folder_ = ::open(archive.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0) throw UsageError(archive.string() + ": no folder can be made there");
  if (::flock(folder_, LOCK_EX | LOCK_NB) == 0) return;
  ::close(folder_);
  throw UsageError(archive.string() + ": another process copies runs into it");
}

FolderArchive::~FolderArchive() { ::close(folder_); }

fs::path FolderArchive::look(const std::string& name) {
  return fs::exists(archive_ / name) ? archive_ / name : fs::path();
}

void FolderArchive::send(const fs::path& run, const std::string& name, bool renews, bool thorough,
                         const std::atomic<bool>* stop) {
  std::vector<std::string> how;
  if (thorough) how.push_back("--checksum");
  if (renews) how.push_back("--link-dest=" + (archive_ / name).string());
  rsync_run(how, fs::absolute(run).string() + "/", (archive_ / (kArriving + name)).string() + "/", stop);
}

std::string FolderArchive::verify(const fs::path&, const std::string& name, const std::string& digest,
                                  const std::atomic<bool>*) {
  const SealCheck arrived = check_seals(archive_ / (kArriving + name), true);
  if (arrived.whole() && !arrived.seals.empty() && arrived.seals.back().digest == digest) return "";
  return arrived.lines().empty() ? "its seals are others" : arrived.lines().front();
}

void FolderArchive::keep(const std::string& name, bool renews) {
  const fs::path target = archive_ / name, going = archive_ / (kRemoving + name);
  if (renews) {
    fs::remove_all(going);
    fs::rename(target, going);
  }
  fs::rename(archive_ / (kArriving + name), target);
  record::sync_folder(archive_);
  fs::remove_all(going);
}

ArchiveCopy copy_to_archive(const fs::path& run, Archive& archive, const std::atomic<bool>* stop) {
  const std::string name = fs::canonical(run).filename().string();
  std::optional<Seal> newest = newest_seal(run);
  if (!newest) return left_out("it is not sealed");
  if (newest->open) return left_out("its print has not ended, or its end is not sealed");
  const fs::path target = archive.look(name);
  const bool there = !target.empty();
  if (there && !is_run(target)) return left_out(name + " is no run there");
  if (there) {
    const std::optional<Seal> kept = newest_seal(target);
    if (!kept || kept->run_id != newest->run_id) return left_out("another run has this name there");
    if (kept->digest == newest->digest && notes_size(run) == notes_size(target))
      return {ArchiveCopy::State::kThere, "", newest->digest};
  }
  if (notes_size(run) != sealed_notes_size(*newest)) seal_its_notes(run);
  const RunLock still(run, RunUse::kRead);
  const SealCheck whole = check_seals(run);
  if (!whole.lines().empty()) return left_out("it is not as it was sealed: " + whole.lines().front());
  const std::string digest = whole.seals.back().digest;
  // A file that an earlier call left, or that changed on the way, has the right size and time and is sent
  // again once.
  archive.send(run, name, there, false, stop);
  std::string why = archive.verify(run, name, digest, stop);
  if (!why.empty()) {
    archive.send(run, name, there, true, stop);
    why = archive.verify(run, name, digest, stop);
  }
  if (!why.empty()) return left_out("the copy is not what was sealed: " + why);
  archive.keep(name, there);
  return {there ? ArchiveCopy::State::kRenewed : ArchiveCopy::State::kCopied, "", digest};
}

}  // namespace firn::runs
