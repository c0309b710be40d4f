#include "studies/compare/study_shards.h"

#include <algorithm>
#include <set>
#include <string>
#include <tuple>

#include "core/options/number.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr int kMostShards = 100'000;
constexpr const char* kFolder = "shards";

}  // namespace

StudyShard parse_shard(std::string_view text) {
  const std::size_t slash = text.find('/');
  const auto number = whole_number<int>(text.substr(0, slash)),
             of = slash == text.npos ? std::nullopt : whole_number<int>(text.substr(slash + 1));
  if (!number || !of || *number < 1 || *number > *of || *of > kMostShards)
    throw UsageError("--shard " + std::string(text) +
                     ": K/N is wanted, with 1 <= K <= N <= " + std::to_string(kMostShards));
  return {*number, *of};
}

namespace {

// Schemes that are configured alike are one print.
std::vector<const StudyCell*> unlike_cells(const StudyPlan& plan) {
  std::set<std::string_view> seen;
  std::vector<const StudyCell*> unlike;
  for (const StudyCell& c : plan.cells)
    if (seen.insert(c.digest).second) unlike.push_back(&c);
  return unlike;
}

// The n-th belongs to shard n modulo their number.
std::vector<const StudyCell*> dealt_cells(const StudyPlan& plan) {
  std::vector<const StudyCell*> dealt = unlike_cells(plan);
  std::ranges::sort(dealt, {}, [](const StudyCell* c) { return std::tie(c->arm, c->part, c->digest); });
  return dealt;
}

}  // namespace

std::vector<int> shards_to_do(const StudyPlan& plan, const StudyJournal& journal, int of) {
  const std::vector<const StudyCell*> dealt = dealt_cells(plan);
  std::vector<bool> has(std::size_t(of), false);
  for (std::size_t n = 0; n < dealt.size(); ++n)
    if (!journal.find(dealt[n]->digest)) has[n % std::size_t(of)] = true;
  std::vector<int> numbers;
  for (int k = 1; k <= of; ++k)
    if (has[std::size_t(k - 1)]) numbers.push_back(k);
  return numbers;
}

std::vector<const StudyCell*> cells_of(const StudyPlan& plan, const StudyShard& shard) {
  if (shard.of == 1) return unlike_cells(plan);
  const std::vector<const StudyCell*> dealt = dealt_cells(plan);
  std::vector<const StudyCell*> own;
  for (std::size_t n = std::size_t(shard.number - 1); n < dealt.size(); n += std::size_t(shard.of))
    own.push_back(dealt[n]);
  std::ranges::sort(own);  // addresses in the plan's list
  return own;
}

ShardFile::ShardFile(const std::filesystem::path& study_folder, const StudyShard& shard)
    : stem_(study_folder / kFolder / (std::to_string(shard.number) + "-of-" + std::to_string(shard.of))),
      at_work_(stem_.string() + ".part") {
  std::error_code error;
  std::filesystem::create_directories(stem_.parent_path(), error);
  if (error) throw UsageError(stem_.parent_path().string() + ": cannot be made: " + error.message());
}

std::filesystem::path ShardFile::finish() const {
  std::filesystem::path to = stem_.string() + ".journal";
  for (int n = 2; std::filesystem::exists(to); ++n)
    to = stem_.string() + "." + std::to_string(n) + ".journal";
  std::error_code error;
  std::filesystem::rename(at_work_, to, error);
  if (error) throw UsageError(at_work_.string() + ": cannot be renamed: " + error.message());
  return to;
}

std::filesystem::path results_journal(const std::filesystem::path& folder) {
  return folder / "results.journal";
}

void take_journals(StudyJournal& journal, const std::filesystem::path& folder,
                   const std::filesystem::path& except) {
  std::vector<std::filesystem::path> all = shard_journals(folder);
  if (const auto own = results_journal(folder); std::filesystem::exists(own)) all.insert(all.begin(), own);
  for (const std::filesystem::path& other : all)
    if (other != except) journal.take(other);
}

std::vector<std::filesystem::path> shard_journals(const std::filesystem::path& study_folder) {
  std::vector<std::filesystem::path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(study_folder / kFolder, none))
    if (const auto end = entry.path().extension(); end == ".journal" || end == ".part")
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

}  // namespace firn
