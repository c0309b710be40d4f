#include "runs/folder/incarnation_seal.h"

#include <algorithm>
#include <stdexcept>

#include "files/exit_codes.h"
#include "files/record/file.h"
#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runtime/write_ahead.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

fs::path seal_path(const fs::path& run, std::int64_t number) {
  return RunPaths(run).seals_path() / (std::to_string(number) + ".seal");
}

/// Highest incarnation that began, of all write-ahead files; -1: none.
std::int32_t newest_incarnation(const fs::path& run) {
  std::int32_t newest = -1;
  for (const fs::path& file : RunPaths(run).wal_files()) {
    const record::MappedFile mapped(file);
    record::RecordReader reader(mapped.bytes());
    while (const auto record = reader.next()) {
      if (record->damaged || record->kind != std::uint16_t(WalKind::kHead)) continue;
      try {
        newest = std::max(newest, decode_head(record->payload).incarnation);
      } catch (const std::runtime_error&) {  // the resume names it
      }
    }
  }
  return newest;
}

void write_seal(const fs::path& run, Seal seal) {
  const fs::path path = seal_path(run, seal.number);
  write_file_atomically(path, encode_seal(seal));
  record::sync_folder(path.parent_path());
  record::sync_folder(run);
}

// The seal that follows those of `c`.
Seal next_seal(const SealCheck& c) {
  Seal s;
  s.files = c.files;
  if (c.seals.empty()) return s;
  const Seal& before = c.seals.back();
  s.number = before.number + 1;
  s.run_id = before.run_id;
  s.incarnation = before.incarnation;
  s.before = before.digest;
  return s;
}

// The run has not ended: its resume writes the result and seals it. Where the folder has gone there is
// nothing to remove, and a sync would meet the same disk.
void remove_end(const fs::path& run) {
  std::error_code error;
  fs::remove(RunPaths(run).result_path(), error);
  try {
    const SealCheck c = check_seals(run, false);
    if (!c.seals.empty() && !c.seals.back().open) fs::remove(seal_path(run, c.seals.back().number), error);
  } catch (const std::exception&) {
  }
}

std::string since(const SealDifference& d, const std::string& when) { return to_text(d) + ", found " + when; }

}  // namespace

SealedIncarnation::SealedIncarnation(const fs::path& run, std::int64_t run_id, bool resume, bool unsealed)
    : run_(run) {
  fs::create_directories(RunPaths(run).seals_path());
  SealCheck c = check_seals(run, true);
  if (!resume) c.differs.clear();  // a new run has no seal yet
  // After a kill between the result and its seal the run goes on as from any end without a seal.
  if (!c.seals.empty() && c.seals.back().open)
    std::erase_if(c.differs, [](const SealDifference& d) { return d.file == RunPaths::kResult; });
  if (!c.differs.empty() && !unsealed) require_seals(run, false);
  Seal s = next_seal(c);
  s.run_id = run_id;
  s.open = true;
  s.incarnation = resume ? newest_incarnation(run) + 1 : 0;
  s.reason = resume ? "resume" : "start";
  for (const SealDifference& d : c.differs)
    s.differs.push_back(since(d, "when incarnation " + std::to_string(s.incarnation) + " began"));
  if (c.seals.empty() && resume)
    s.reason = "resume of a run without seals" + std::string(kAsFound);
  else if (!c.seals.empty() && c.seals.back().open)
    s.reason = "resume after an end without a seal" + std::string(kAsFound);
  write_seal(run, s);
}

void SealedIncarnation::ended(RunResult& result) try {
  const SealCheck c = check_seals(run_, true);
  Seal s = next_seal(c);
  s.reason = result.outcome;
  for (const SealDifference& d : c.differs)
    if (d.file != RunPaths::kResult)
      s.differs.push_back(since(d, "when incarnation " + std::to_string(s.incarnation) + " ended"));
  write_seal(run_, s);
} catch (const std::exception& e) {
  remove_end(run_);
  result.outcome = "stopped safely";
  result.status = kSafetyStop;
  result.reason = std::string("the run could not be sealed: ") + e.what();
}

void seal_repaired(const fs::path& run, const SealCheck& before) {
  if (before.seals.empty() || before.seals.back().open) return;
  Seal s = next_seal(check_seals(run, true));
  s.reason = "log repaired";
  for (const SealDifference& d : before.differs) s.differs.push_back(since(d, "before the log was repaired"));
  write_seal(run, s);
}

bool seal_end(const fs::path& run, const std::string& reason) {
  const SealCheck c = check_seals(run, true);
  if (c.seals.empty() || !c.seals.back().open) return false;
  Seal s = next_seal(c);
  s.reason = reason + kAsFound;
  for (const SealDifference& d : c.differs)
    if (d.file != RunPaths::kResult) s.differs.push_back(since(d, "when the end was sealed"));
  write_seal(run, s);
  return true;
}

bool seal_notes(const fs::path& run) {
  const SealCheck c = check_seals(run, true);
  if (c.seals.empty() || c.seals.back().open) return false;
  if (!c.differs.empty())
    throw UsageError(run.string() + ": is not as it was sealed: " + to_text(c.differs.front()));
  const auto size = [](const std::vector<SealedFile>& files) {
    const auto at = std::ranges::find(files, RunPaths::kNotes, &SealedFile::path);
    return at == files.end() ? 0 : at->bytes;
  };
  if (size(c.files) == size(c.seals.back().files)) return false;
  Seal s = next_seal(c);
  s.reason = "notes";
  write_seal(run, s);
  return true;
}

void seal_derived(const fs::path& run, const std::vector<std::string>& files) {
  const SealCheck c = check_seals(run);
  if (c.seals.empty()) return;
  Seal s;
  s.run_id = c.seals.back().run_id;
  s.reason = "made from the run";
  s.before = c.seals.back().digest;
  for (const std::string& file : files) {
    const FileDigests d = digest_file(run / file, {});
    s.files.push_back({file, d.bytes, d.sha256, true});
  }
  write_file_atomically(RunPaths(run).seals_path() / kDerivedSeal, encode_seal(s));
}

}  // namespace firn::runs
