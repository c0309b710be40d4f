#include "runs/folder/one_run.h"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "files/record/packed.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/documents.h"
#include "runs/folder/recorded_steps.h"
#include "runs/folder/seal.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

struct Origin {
  fs::path file;
  std::int64_t run_id = 0;
};

std::optional<Origin> origin_of(const fs::path& wal) try {
  const auto head = first_head(wal);
  return head ? std::optional(Origin{wal, head->run_id}) : std::nullopt;
} catch (const std::exception&) {
  return std::nullopt;  // replay names a file that cannot be read
}

std::optional<Origin> origin_of_seal(const fs::path& seal) try {
  return Origin{seal, decode_seal(read_file(seal)).run_id};
} catch (const std::exception&) {
  return std::nullopt;  // so do the seals' own checks
}

// The file that says that the run is another one than `told`; none if one says that it is this one: then a
// file of another run lies among its own, which replay and audit name. Plain write-ahead files first, since
// of a packed one all is unpacked; where all are packed, the first seal, which holds their digests.
std::optional<Origin> foreign_origin(const fs::path& run, std::int64_t told) {
  std::optional<Origin> foreign;
  std::vector<fs::path> packed;
  for (const fs::path& wal : RunPaths(run).wal_files()) {
    if (record::is_packed(wal)) {
      packed.push_back(wal);
      continue;
    }
    const auto origin = origin_of(wal);
    if (origin && origin->run_id == told) return std::nullopt;
    if (!foreign) foreign = origin;
  }
  if (foreign || packed.empty()) return foreign;
  if (const auto origin = origin_of_seal(RunPaths(run).seals_path() / "0.seal"))
    return origin->run_id == told ? std::nullopt : origin;
  for (const fs::path& wal : packed)
    if (const auto origin = origin_of(wal)) return origin->run_id == told ? std::nullopt : origin;
  return std::nullopt;
}

}  // namespace

void require_one_run(const fs::path& run) {
  const fs::path document = RunPaths(run).provenance_path();
  std::optional<std::int64_t> told;
  try {
    told = parse_provenance(read_file(document), document.string()).run_id;
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  if (!told) return;
  const auto origin = foreign_origin(run, *told);
  if (!origin) return;
  throw UsageError(document.string() + ": is of run " + std::to_string(*told) + ", and " +
                   origin->file.string() + " of run " + std::to_string(origin->run_id) +
                   ": put back the document of the run");
}

}  // namespace firn::runs
