#include "studies/compare/study_shards.h"

#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "core/options/number.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr int kMostShards = 100'000;
constexpr const char* kFolder = "shards";
// Its shard may end, and rename it, between a look and the next, and a shared folder may show its old name.
constexpr int kReads = 10;

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

// Kinds that are configured alike are one print.
std::vector<const StudyCell*> unlike_cells(const StudyWork& work) {
  std::set<std::string_view> seen;
  std::vector<const StudyCell*> unlike;
  for (const StudyCell& c : work.cells)
    if (seen.insert(c.digest).second) unlike.push_back(&c);
  return unlike;
}

struct Dealt {
  const StudyCell* cell;
  int shard;  // from 1
};

double seconds_of(const StudyWork& work, const StudyCell& cell) {
  return work.seconds.empty() ? 1.0 : work.seconds[cell.arm];
}

std::vector<Dealt> deal(const StudyWork& work, int of) {
  std::vector<const StudyCell*> cells = unlike_cells(work);
  std::ranges::sort(cells, {}, [&](const StudyCell* c) {
    return std::tuple(-seconds_of(work, *c), c->arm, c->part, std::string_view(c->digest));
  });
  using Load = std::pair<double, int>;  // seconds, shard
  std::priority_queue<Load, std::vector<Load>, std::greater<>> least;
  for (int k = 1; k <= of; ++k) least.emplace(0.0, k);
  std::vector<Dealt> dealt;
  for (const StudyCell* c : cells) {
    const auto [load, shard] = least.top();
    least.pop();
    dealt.push_back({c, shard});
    least.emplace(load + seconds_of(work, *c), shard);
  }
  return dealt;
}

}  // namespace

std::vector<int> shards_to_do(const StudyWork& work, const StudyJournal& journal, int of) {
  std::set<int> numbers;
  for (const Dealt& d : deal(work, of))
    if (!journal.find(d.cell->digest)) numbers.insert(d.shard);
  return {numbers.begin(), numbers.end()};
}

std::vector<const StudyCell*> cells_of(const StudyWork& work, const StudyShard& shard) {
  if (shard.of == 1) return unlike_cells(work);
  std::vector<const StudyCell*> own;
  for (const Dealt& d : deal(work, shard.of))
    if (d.shard == shard.number) own.push_back(d.cell);
  std::ranges::sort(own);  // addresses in the work's list
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
  if (const auto own = results_journal(folder); own != except && std::filesystem::exists(own))
    journal.take(own);
  std::set<std::filesystem::path> taken{except};
  std::map<std::filesystem::path, int> failed;
  for (bool again = true; again;) {
    again = false;
    for (const std::filesystem::path& other : shard_journals(folder)) {
      if (taken.contains(other)) continue;
      again = true;
      try {
        journal.take(other);
        taken.insert(other);
      } catch (const UsageError&) {
        if (std::filesystem::exists(other) && ++failed[other] == kReads) throw;  // else it has another name
      }
    }
  }
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
