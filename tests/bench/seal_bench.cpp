// The time to seal a message of the bus, and to check its seal, by size of the message.
#include <benchmark/benchmark.h>

#include <vector>

#include "procs/bus/message_seal.h"

namespace {

using namespace firn;

void seal(benchmark::State& state) {
  MessageSeal seal(BusKey::random());
  const std::vector<std::byte> message(std::size_t(state.range(0)));
  std::byte trailer[kSealBytes];
  for (auto _ : state) {
    seal.seal("HEIGHT_MAP_TILES", message, trailer);
    benchmark::DoNotOptimize(trailer);
  }
  state.SetBytesProcessed(state.iterations() * state.range(0));
}

void check(benchmark::State& state) {
  const BusKey key = BusKey::random();
  MessageSeal seal(key);
  SealVerifier check(key);
  const std::size_t size = std::size_t(state.range(0));
  std::vector<std::byte> message(size + kSealBytes);
  seal.seal("HEIGHT_MAP_TILES", std::span(message).first(size), std::span(message).last<kSealBytes>());
  for (auto _ : state) {  // repeated but for the first: the hash is computed all the same
    std::span<const std::byte> view(message);
    benchmark::DoNotOptimize(check.open("HEIGHT_MAP_TILES", view));
  }
  state.SetBytesProcessed(state.iterations() * state.range(0));
}

BENCHMARK(seal)->Arg(100)->Arg(10'000)->Arg(60'000);
BENCHMARK(check)->Arg(100)->Arg(10'000)->Arg(60'000);

}  // namespace
