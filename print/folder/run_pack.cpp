#include "print/folder/run_pack.h"

#include <algorithm>
#include <string>
#include <vector>

#include "drivers/link/dialect.h"
#include "files/record/file.h"
#include "files/record/packed.h"
#include "files/text_file.h"
#include "print/folder/running.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using logfile::MappedFile;

constexpr std::uintmax_t kSmall_bytes = 4096;

bool is_record(const std::string& path) {
  return path.starts_with("log.lcm") || path == "world.rec" || path.starts_with("world/") ||
         (path.starts_with("nodes/") && (path.ends_with(".wal") || path.ends_with(".sent")));
}

// The log last: the others are packed with its messages as known text.
std::vector<fs::path> records(const fs::path& run) {
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(run); it != fs::recursive_directory_iterator(); ++it) {
    const std::string path = it->path().lexically_relative(run).generic_string();
    if (it->symlink_status().type() == fs::file_type::regular && is_record(path) && path != "log.lcm")
      files.push_back(it->path());
  }
  std::ranges::sort(files);
  if (fs::is_regular_file(run / "log.lcm")) files.push_back(run / "log.lcm");
  return files;
}

bool same(const fs::path& packed, std::span<const std::byte> plain) {
  const MappedFile file(packed);
  return std::ranges::equal(file.bytes(), plain);
}

void pack_file(const fs::path& file, const fs::path& log) {
  const MappedFile plain(file);
  const bool has_log = file != log && fs::exists(log);
  std::vector<std::byte> packed;
  if (has_log) {
    const MappedFile known(log);
    packed = logfile::pack(plain.bytes(), known.bytes(),
                           log.lexically_relative(file.parent_path()).generic_string());
  } else {
    packed = logfile::pack(plain.bytes(), {}, "");
  }
  if (packed.size() >= plain.bytes().size()) return;
  const fs::path trial = file.string() + ".packed";
  write_file_atomically(trial, drivers::text_of(packed));
  if (!same(trial, plain.bytes())) {
    fs::remove(trial);
    throw std::runtime_error(file.string() + ": does not unpack to the same bytes; it stays plain");
  }
  fs::rename(trial, file);
}

}  // namespace

std::uint64_t folder_bytes(const fs::path& folder) {
  std::uint64_t sum = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.symlink_status().type() == fs::file_type::regular) sum += entry.file_size();
  return sum;
}

PackReport pack_run(const fs::path& run) {
  refuse_running(run);
  return pack_records(run);
}

PackReport pack_records(const fs::path& run) {
  PackReport report;
  for (const fs::path& file : records(run)) {
    const std::uintmax_t bytes = fs::file_size(file);
    if (bytes > kSmall_bytes && !logfile::is_packed(file)) pack_file(file, run / "log.lcm");
    report.before += bytes;
    report.after += fs::file_size(file);
  }
  return report;
}

PackReport expand_run(const fs::path& run) {
  refuse_running(run);
  return expand_records(run);
}

PackReport expand_records(const fs::path& run) {
  PackReport report;
  for (const fs::path& file : records(run)) {
    report.before += fs::file_size(file);
    if (logfile::is_packed(file)) {
      const MappedFile plain(file);
      write_file_atomically(file, drivers::text_of(plain.bytes()));
    }
    report.after += fs::file_size(file);
  }
  return report;
}

}  // namespace firn
