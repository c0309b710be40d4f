#include "replay/replayer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <tuple>

#include "files/run_paths.h"
#include "replay/cross_check.h"
#include "replay/log_check.h"
#include "runs/folder/one_run.h"
#include "runs/folder/run_folder.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/companions.h"

namespace firn::replay {
namespace {

namespace fs = std::filesystem;

std::vector<NodeMaker> chosen(const ReplayOptions& options) {
  std::vector<NodeMaker> makers;
  for (const NodeMaker& m : options.makers)
    if (options.only_node.empty() || m.name == options.only_node) makers.push_back(m);
  if (makers.empty()) {
    std::string known;
    for (const NodeMaker& m : options.makers) known += (known.empty() ? "" : ", ") + std::string(m.name);
    throw std::invalid_argument("no node '" + options.only_node + "'; nodes: " + known);
  }
  return makers;
}

// Each node alone; nodes do not see each other, so they run on as many threads as there are.
std::vector<NodeOutcome> replay_nodes(const fs::path& run, const std::vector<NodeMaker>& makers,
                                      const runs::ChannelIndex& channels, const runs::RunMigration& migration,
                                      const ReplayOptions& options) {
  std::vector<NodeOutcome> nodes(makers.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t n = next++; n < makers.size(); n = next++)
      nodes[n] = replay_node(run, makers[n], channels, migration, options);
  };
  const std::size_t wanted =
      options.threads > 0 ? std::size_t(options.threads) : std::thread::hardware_concurrency();
  std::vector<std::jthread> threads;
  for (std::size_t t = 1; t < std::min(wanted, makers.size()); ++t) threads.emplace_back(work);
  work();
  threads.clear();
  return nodes;
}

// The run that most files belong to; a file of another one is foreign.
void check_run_ids(std::vector<NodeOutcome>& nodes) {
  std::vector<std::int64_t> ids;
  for (const NodeOutcome& n : nodes)
    if (n.head) ids.push_back(n.head->run_id);
  std::ranges::sort(ids);
  if (ids.empty() || ids.front() == ids.back()) return;
  std::int64_t run = ids.front();
  for (std::int64_t id : ids)
    if (std::ranges::count(ids, id) > std::ranges::count(ids, run)) run = id;
  for (NodeOutcome& n : nodes) {
    if (!n.head || n.head->run_id == run) continue;
    Finding f;
    f.kind = FindingKind::kForeign;
    f.node = n.verdict.name;
    f.what = RunPaths::wal_name(n.verdict.name) + " is a file of run " + std::to_string(n.head->run_id) +
             ", the run is " + std::to_string(run);
    n.add(std::move(f));
  }
}

void merge_ignored(RunVerdict& verdict, const std::vector<Ignored>& more) {
  if (verdict.ignored.empty())
    verdict.ignored = more;
  else
    for (std::size_t n = 0; n < more.size(); ++n) verdict.ignored[n].times += more[n].times;
}

void merge_largest(RunVerdict& verdict, double largest, const std::string& field) {
  if (largest <= verdict.largest_difference) return;
  verdict.largest_difference = largest;
  verdict.largest_difference_field = field;
}

void merge(RunVerdict& verdict, NodeOutcome& node) {
  for (const std::string& p : node.provenance)
    if (std::ranges::find(verdict.provenance, p) == verdict.provenance.end()) verdict.provenance.push_back(p);
  std::ranges::move(node.damage, std::back_inserter(verdict.damage));
  std::ranges::move(node.findings, std::back_inserter(verdict.findings));
  verdict.findings_total += node.findings_total;
  merge_ignored(verdict, node.ignored);
  merge_largest(verdict, node.largest_difference, node.verdict.name + ": " + node.largest_difference_field);
  verdict.nodes.push_back(std::move(node.verdict));
}

}  // namespace

RunVerdict replay_run(const fs::path& run, const ReplayOptions& options) {
  runs::require_run(run);
  runs::require_one_run(run);
  const auto began = std::chrono::steady_clock::now();
  const std::vector<NodeMaker> makers = chosen(options);
  const runs::ChannelIndex channels;
  const runs::RunMigration migration = runs::migration_of(run);
  std::vector<NodeOutcome> nodes = replay_nodes(run, makers, channels, migration, options);

  RunVerdict verdict;
  verdict.tolerance = options.tolerance;
  for (NodeOutcome& node : nodes)
    if (!node.verdict.python.empty()) verdict.not_replayed.push_back(node.verdict);
  std::erase_if(nodes, [](const NodeOutcome& node) { return !node.verdict.python.empty(); });
  check_run_ids(nodes);
  MessageComparer comparer(options);
  const SentIndex sent(nodes);
  check_deliveries(sent, nodes, comparer);
  check_log(run, sent, channels, migration, comparer, verdict);
  merge_ignored(verdict, comparer.ignored());
  merge_largest(verdict, comparer.largest_difference(), comparer.largest_difference_field());
  for (NodeOutcome& node : nodes) merge(verdict, node);
  std::ranges::stable_sort(verdict.findings, {}, [](const Finding& f) { return std::tuple(f.at, f.kind); });
  verdict.wall_ns = (std::chrono::steady_clock::now() - began) / std::chrono::nanoseconds(1);
  return verdict;
}

}  // namespace firn::replay
