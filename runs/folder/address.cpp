#include "runs/folder/address.h"

#include <limits>
#include <span>
#include <vector>

#include "core/options/number.h"
#include "files/digest.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPlaceDigits = 12;
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

std::int64_t run_id_of(const fs::path& run) try {
  return parse_provenance(read_file(RunPaths(run).provenance_path()), RunPaths::kProvenance)
      .run_id.value_or(0);
} catch (const std::exception&) {
  return 0;
}

}  // namespace

std::string RunAddress::text() const { return std::to_string(run_id) + "@" + place; }

std::string place_of(const fs::path& run) {
  const std::string path = fs::weakly_canonical(run).string();
  return sha256_hex(std::as_bytes(std::span(path))).substr(0, kPlaceDigits);
}

RunAddress address_of(const fs::path& run) { return {run_id_of(run), place_of(run)}; }

std::optional<RunAddress> parse_address(std::string_view text) {
  const std::size_t at = text.find('@');
  if (at == text.npos || text.size() - at - 1 != kPlaceDigits) return std::nullopt;
  const std::string_view place = text.substr(at + 1);
  if (place.find_first_not_of("0123456789abcdef") != place.npos) return std::nullopt;
  const auto run_id = whole_number(text.substr(0, at), std::int64_t{0}, kMost);
  return run_id ? std::optional(RunAddress{*run_id, std::string(place)}) : std::nullopt;
}

fs::path folder_of(const std::string& text, const fs::path& root) {
  const auto address = parse_address(text);
  const auto number = whole_number(text, std::int64_t{0}, kMost);
  std::error_code gone;
  if (fs::exists(text, gone) || !(address || number)) return text;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(root, gone)) {
    if (!is_run(entry.path())) continue;
    const RunAddress of_entry = address_of(entry.path());
    if (address ? of_entry == *address : of_entry.run_id == *number) found.push_back(entry.path());
  }
  if (found.size() == 1) return found.front();
  std::string all;
  for (const fs::path& folder : found) all += (all.empty() ? "" : ", ") + folder.string();
  throw UsageError(text + (found.empty() ? ": no such folder, and no run of this number in " + root.string()
                                         : ": several folders hold this run: " + all + "; name one of them"));
}

}  // namespace firn::runs
