#include <cstdio>
#include <filesystem>
#include <vector>

#include "tests/bench/bench.h"

namespace firn::bench {
namespace {

std::vector<const Bench*>& benches() {
  static std::vector<const Bench*> all;
  return all;
}

}  // namespace

Bench::Bench(std::string_view n, Main* r) : name(n), run(r) { benches().push_back(this); }

}  // namespace firn::bench

int main(int argc, char** argv) {
  const std::string called = std::filesystem::path(argv[0]).filename();
  for (const firn::bench::Bench* b : firn::bench::benches())
    if (b->name == called) return b->run(argc, argv);
  std::fprintf(stderr, "%s is no bench; call one of these by its name in build/bench:\n", called.c_str());
  for (const firn::bench::Bench* b : firn::bench::benches())
    std::fprintf(stderr, "  %.*s\n", int(b->name.size()), b->name.data());
  return 2;
}
