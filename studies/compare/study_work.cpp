#include "studies/compare/study_work.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>

#include "studies/compare/study_shards.h"

namespace firn {

std::vector<const StudyCell*> prints_to_do(const StudyWork& work, const StudyJournal& journal,
                                           const StudyRunOptions& options) {
  const auto wanted_print = [&](const StudyCell* c) {
    const StudyPrint* print = journal.find(c->digest);
    return options.again ? print && !print->finished : !print;
  };
  std::vector<const StudyCell*> to_do = cells_of(work, options.shard);
  std::erase_if(to_do, [&](const StudyCell* c) { return !wanted_print(c); });
  if (options.first_of_each) {
    std::vector<bool> known(work.kinds.size(), !work.seconds.empty());
    for (const StudyCell* c : cells_of(work, options.shard))
      if (journal.find(c->digest)) known[c->arm] = true;
    std::erase_if(to_do, [&](const StudyCell* c) {
      const bool was_known = known[c->arm];
      known[c->arm] = true;
      return was_known;
    });
  }
  if (options.most > 0 && to_do.size() > options.most) to_do.resize(options.most);
  return to_do;
}

StudyRunSummary run_study(const StudyWork& work, StudyJournal& journal, const StudyRunOptions& options) {
  const std::vector<const StudyCell*> to_do = prints_to_do(work, journal, options);

  StudyRunSummary summary;
  summary.to_do = to_do.size();
  std::size_t failed = 0;
  std::mutex mutex;  // of everything below but `next`
  std::exception_ptr error;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> broken{false};
  const auto make_some = [&] {
    try {
      while (!broken && !(options.stop && *options.stop)) {
        const std::size_t n = next++;
        if (n >= to_do.size()) return;
        const StudyCell& c = *to_do[n];
        const StudyPrint print = work.make(c);
        const std::lock_guard lock(mutex);
        journal.append(c.digest, work.kinds[c.arm], work.parts[c.part], work.seeds[c.seed], print);
        ++summary.done;
        summary.cpu_s += print.cpu_s;
        failed += !print.within.value_or(print.finished);
        if (options.progress) options.progress(summary.done, failed);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
      broken = true;
    }
  };
  const std::size_t wanted =
      options.threads > 0 ? std::size_t(options.threads) : std::max(1u, std::thread::hardware_concurrency());
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 1; t < std::min(wanted, to_do.size()); ++t) threads.emplace_back(make_some);
    make_some();
  }
  if (error) std::rethrow_exception(error);
  return summary;
}

}  // namespace firn
