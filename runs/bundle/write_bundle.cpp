#include <fcntl.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <deque>
#include <memory>
#include <set>

#include "files/digest.h"
#include "files/record/open_file.h"
#include "files/record/output_target.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/bundle/bundle.h"
#include "runs/bundle/crate.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/running.h"
#include "runs/folder/seal_check.h"
#include "runs/folder/trial_files.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr std::array kSquashed{".toml", ".json", ".jsonl", ".csv", ".html", ".seal", ".diff", ".out", ".idx"};

std::string now_text() {
  const std::time_t t = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm tm{};
  gmtime_r(&t, &tm);
  std::array<char, 32> text;
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &tm);
  return text.data();
}

// Bytes as they are in the folder: a packed record stays packed.
CrateFile digested(const fs::path& run, const fs::path& file) {
  CrateFile f{file.lexically_relative(run).generic_string(), 0, ""};
  const record::OpenedFile opened = record::open_file(file, O_RDONLY);
  if (opened.fd < 0) throw UsageError(file.string() + ": cannot be read");
  Sha256 digest;
  std::vector<std::byte> block(std::size_t(1) << 20);
  ssize_t n = 0;
  while ((n = ::read(opened.fd, block.data(), block.size())) > 0) {
    digest.add(std::span(block).first(std::size_t(n)));
    f.bytes += std::uint64_t(n);
  }
  ::close(opened.fd);
  if (n < 0) throw UsageError(file.string() + ": cannot be read");
  f.sha256 = digest.hex();
  return f;
}

CrateRun gathered(const fs::path& run) {
  CrateRun r{run, fs::canonical(run).filename().string(), {}};
  for (const auto& entry : fs::recursive_directory_iterator(run)) {
    const std::string path = entry.path().lexically_relative(run).generic_string();
    const bool ours = path == RunPaths::kLock || path == RunPaths::kInstrumentsLock || is_trial_file(path);
    if (!ours && entry.symlink_status().type() == fs::file_type::regular)
      r.files.push_back(digested(run, entry.path()));
  }
  std::ranges::sort(r.files, {}, &CrateFile::path);
  return r;
}

void refuse_unsealed(const fs::path& run) {
  if (printing_process(run)) throw UsageError(run.string() + ": is being printed");
  const SealCheck c = check_seals(run);
  if (c.seals.empty()) throw UsageError(run.string() + ": is not sealed: nobody could tell a change of it");
  if (!c.lines().empty()) throw UsageError(run.string() + ": is not as it was sealed: " + c.lines().front());
}

class Archive {
 public:
  explicit Archive(const fs::path& file)
      : target_(record::output_target(file)), part_(target_.string() + ".part") {
    int error = 0;
    archive_.reset(zip_open(part_.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error));
    if (!archive_) throw UsageError(file.string() + ": cannot be written");
  }
  ~Archive() {
    archive_.reset();
    std::error_code ignored;
    if (!done_) fs::remove(part_, ignored);
  }
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  void add_text(const std::string& name, const std::string& text) {
    add(name, zip_source_buffer(archive_.get(), text.data(), text.size(), 0), true);
  }
  void add_file(const std::string& name, const fs::path& file) {
    const bool squash = std::ranges::any_of(kSquashed, [&](const char* e) { return name.ends_with(e); });
    add(name, zip_source_file(archive_.get(), file.c_str(), 0, 0), squash);
  }
  void finish(const std::function<void(double)>& progress) {
    zip* archive = archive_.get();
    if (progress)
      zip_register_progress_callback_with_state(
          archive, 0.01,
          [](zip_t*, double fraction, void* told) {
            (*static_cast<const std::function<void(double)>*>(told))(fraction);
          },
          nullptr, const_cast<void*>(static_cast<const void*>(&progress)));
    if (zip_close(archive) != 0) throw WriteError(target_.string() + ": " + zip_strerror(archive));
    static_cast<void>(archive_.release());
    std::error_code error;
    fs::rename(part_, target_, error);
    if (error) throw WriteError(target_.string() + ": " + error.message());
    done_ = true;
  }

 private:
  struct Discard {
    void operator()(zip* archive) const { zip_discard(archive); }
  };
  void add(const std::string& name, zip_source_t* source, bool squash) {
    const zip_int64_t n = source ? zip_file_add(archive_.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (n < 0) {
      if (source) zip_source_free(source);
      throw WriteError(target_.string() + ": " + name + ": " + zip_strerror(archive_.get()));
    }
    zip_set_file_compression(archive_.get(), zip_uint64_t(n), squash ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0);
  }

  fs::path target_, part_;
  std::unique_ptr<zip, Discard> archive_;
  bool done_ = false;
};

}  // namespace

BundleReport write_bundle(const std::vector<fs::path>& runs, const fs::path& file, const std::string& license,
                          const std::function<void(double)>& progress) {
  std::deque<RunLock> still;
  std::vector<CrateRun> gathered_runs;
  std::set<std::string> names;
  for (const fs::path& run : runs) {
    require_run(run);
    still.emplace_back(run, RunUse::kRead);
    refuse_unsealed(run);
    gathered_runs.push_back(gathered(run));
    if (!names.insert(gathered_runs.back().name).second)
      throw UsageError(run.string() + ": two runs have the name " + gathered_runs.back().name +
                       ", which names their folder");
  }
  const std::string root = file.stem().string();
  BundleReport report;
  Archive archive(file);
  const std::string metadata = crate_metadata(root, gathered_runs, now_text(), license);
  archive.add_text(root + "/" + kCrateMetadata, metadata);
  for (const CrateRun& run : gathered_runs)
    for (const CrateFile& f : run.files) {
      archive.add_file(root + "/" + run.name + "/" + f.path, run.folder / f.path);
      ++report.files;
      report.bytes += f.bytes;
    }
  archive.finish(progress);
  return report;
}

}  // namespace firn::runs
