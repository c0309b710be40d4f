#include "runtime/thread_pool.h"

#include <algorithm>
#include <memory>
#include <thread>

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <vector>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace firn {

int thread_count(int wanted) {
  return wanted > 0 ? wanted : int(std::max(1u, std::thread::hardware_concurrency()));
}

#ifdef __SANITIZE_THREAD__

// Debian's oneTBB is not built for ThreadSanitizer, which then takes its handing over of work for races.
// Plain threads let it see the data that the bodies share.
ParallelFor parallel_on(int threads) {
  if (threads <= 1) return serially;
  return [threads](int n, const std::function<void(int)>& body) {
    std::atomic<int> next{0};
    std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(threads));
    const auto work = [&](int worker) {
      try {
        for (int i = next++; i < n; i = next++) body(i);
      } catch (...) {
        thrown[std::size_t(worker)] = std::current_exception();
        next = n;
      }
    };
    {
      std::vector<std::jthread> helpers;
      for (int worker = 1; worker < threads; ++worker) helpers.emplace_back(work, worker);
      work(0);
    }
    for (const std::exception_ptr& error : thrown)
      if (error) std::rethrow_exception(error);
  };
}

#else

ParallelFor parallel_on(int threads) {
  if (threads <= 1) return serially;
  struct Pool {
    tbb::global_control limit;  // more threads than cores are allowed: tests ask for them
    tbb::task_arena arena;
    explicit Pool(int threads)
        : limit(tbb::global_control::max_allowed_parallelism, std::size_t(threads)), arena(threads) {}
  };
  const auto pool = std::make_shared<Pool>(threads);
  return [pool](int n, const std::function<void(int)>& body) {
    pool->arena.execute([&] {
      tbb::parallel_for(
          0, n, [&](int i) { body(i); }, tbb::simple_partitioner());
    });
  };
}

#endif

}  // namespace firn
