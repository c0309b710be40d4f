#include "runs/folder/pack.h"

#include <sys/uio.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "files/record/file.h"
#include "files/record/packed.h"
#include "files/record/part_file.h"
#include "files/run_paths.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/trial_files.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;
using record::MappedFile;

constexpr std::uintmax_t kSmall_bytes = 4096;
constexpr std::size_t kHeld_bytes = std::size_t(16) << 20;  // of a plain file, in memory

bool is_record(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return path.starts_with(RunPaths::kLog) || path == RunPaths::kWorldRecord || folder == RunPaths::kWorld ||
         (folder == RunPaths::kNodes && RunPaths::is_sent_record(path));
}

// The log last: the others are packed with its messages as known text.
std::vector<fs::path> records(const fs::path& run) {
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(run); it != fs::recursive_directory_iterator(); ++it) {
    const std::string path = it->path().lexically_relative(run).generic_string();
    if (it->symlink_status().type() == fs::file_type::regular && is_record(path) && !is_trial_file(path) &&
        path != RunPaths::kLog)
      files.push_back(it->path());
  }
  std::ranges::sort(files);
  if (const fs::path log = RunPaths(run).log_path(); fs::is_regular_file(log)) files.push_back(log);
  return files;
}

// Follows the work on the files of a run by their bytes.
class Work {
 public:
  Work(const fs::path& run, const PackWatch& watch) : run_(run), watch_(watch), files_(records(run)) {
    for (const fs::path& file : files_) bytes_ += fs::file_size(file);
  }

  const std::vector<fs::path>& files() const { return files_; }
  bool goes_on() const { return !watch_.interrupted || !watch_.interrupted(); }
  // Tells how much of a file is done. @returns false: the work is to end
  bool told(const fs::path& file, std::uint64_t bytes, double share) const {
    if (watch_.progress)
      watch_.progress((double(done_) + share * double(bytes)) / double(std::max<std::uint64_t>(bytes_, 1)),
                      file.lexically_relative(run_).generic_string());
    return goes_on();
  }
  void done(std::uint64_t bytes) { done_ += bytes; }

 private:
  const fs::path& run_;
  const PackWatch& watch_;
  std::vector<fs::path> files_;
  std::uint64_t bytes_ = 0, done_ = 0;
};

// Writes a trial file and lets it take the place of the file, if `write` says so.
void replace(const fs::path& file, const std::function<bool(record::File&)>& write) {
  const record::PartFile trial(file.string() + ".part");
  try {
    record::File out(trial.path(), record::File::Mode::kCreate);
    if (!write(out)) return trial.remove();
    out.sync();
    out.close();
    fs::rename(trial.path(), file);
    record::sync_folder(file.parent_path());
  } catch (...) {
    trial.remove();
    throw;
  }
}

void append(record::File& file, std::span<const std::byte> bytes) {
  iovec part{const_cast<std::byte*>(bytes.data()), bytes.size()};
  file.write({&part, 1});
}

void pack_file(const fs::path& file, const fs::path& log, const Work& work) {
  const MappedFile plain(file);
  const std::size_t size = plain.bytes().size();
  std::optional<MappedFile> known;
  // The nodes' files repeat the log's messages; the index and the world's files have none.
  if (file.parent_path().filename() == RunPaths::kNodes && fs::exists(log)) known.emplace(log);
  std::size_t held = 0;
  const auto goes_on = [&](std::size_t read) {
    if (read >= held + kHeld_bytes) {
      plain.forget();
      held = read;
    }
    return work.told(file, size, double(read) / double(2 * size));
  };
  replace(file, [&](record::File& out) {
    const auto header = record::pack(
        plain.bytes(), known ? known->bytes() : std::span<const std::byte>{},
        log.lexically_relative(file.parent_path()).generic_string(),
        [&](std::span<const std::byte> bytes) { append(out, bytes); }, goes_on);
    if (!header || out.position() >= size) return false;
    out.overwrite(0, *header);
    return true;
  });
}

void expand_file(const fs::path& file) {
  const MappedFile packed(file, MappedFile::Packed::kAsIs);
  record::PackedReader reader(file, packed.bytes());
  replace(file, [&](record::File& out) {
    for (auto part = reader.next(); !part.empty(); part = reader.next()) append(out, part);
    return true;
  });
}

}  // namespace

std::uint64_t folder_bytes(const fs::path& folder) {
  std::uint64_t sum = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.symlink_status().type() == fs::file_type::regular) sum += entry.file_size();
  return sum;
}

PackReport pack_run(const fs::path& run, const PackWatch& watch) {
  const RunLock lock(run, RunUse::kWrite);
  return pack_records(run, watch);
}

PackReport pack_records(const fs::path& run, const PackWatch& watch) {
  PackReport report;
  Work work(run, watch);
  for (const fs::path& file : work.files()) {
    const std::uintmax_t bytes = fs::file_size(file);
    report.interrupted = report.interrupted || !work.goes_on();
    if (!report.interrupted && bytes > kSmall_bytes && !record::is_packed(file))
      pack_file(file, RunPaths(run).log_path(), work);
    work.done(bytes);
    report.before += bytes;
    report.after += fs::file_size(file);
  }
  report.interrupted = report.interrupted || !work.goes_on();
  return report;
}

PackReport expand_run(const fs::path& run, const PackWatch& watch) {
  const RunLock lock(run, RunUse::kWrite);
  return expand_records(run, watch);
}

PackReport expand_records(const fs::path& run, const PackWatch& watch) {
  PackReport report;
  Work work(run, watch);
  for (const fs::path& file : work.files()) {
    const std::uintmax_t bytes = fs::file_size(file);
    report.interrupted = report.interrupted || !work.told(file, bytes, 0.0);
    if (!report.interrupted && record::is_packed(file)) expand_file(file);
    work.done(bytes);
    report.before += bytes;
    report.after += fs::file_size(file);
  }
  return report;
}

}  // namespace firn::runs
