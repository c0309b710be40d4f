#include "cli/thread_pool.h"

#include <algorithm>
#include <memory>
#include <thread>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace firn {

int thread_count(int wanted) { return wanted > 0 ? wanted : int(std::max(1u, std::thread::hardware_concurrency())); }

ParallelFor parallel_on(int threads) {
  if (threads <= 1) return serially;
  const auto arena = std::make_shared<tbb::task_arena>(threads);
  return [arena](int n, const std::function<void(int)>& body) {
    arena->execute([&] { tbb::parallel_for(0, n, [&](int i) { body(i); }, tbb::simple_partitioner()); });
  };
}

}  // namespace firn
