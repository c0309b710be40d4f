// The time to write the authentication code of a message of the bus, and to check it, by size of the message.
#include <benchmark/benchmark.h>

#include <vector>

#include "procs/bus/message_mac.h"

namespace {

using namespace firn;

void write_mac(benchmark::State& state) {
  MessageMac mac(BusKey::random());
  const std::vector<std::byte> message(std::size_t(state.range(0)));
  std::byte trailer[kMacTrailerBytes];
  for (auto _ : state) {
    mac.write("HEIGHT_MAP_TILES", message, trailer);
    benchmark::DoNotOptimize(trailer);
  }
  state.SetBytesProcessed(state.iterations() * state.range(0));
}

void check(benchmark::State& state) {
  const BusKey key = BusKey::random();
  MessageMac mac(key);
  MacVerifier check(key);
  const std::size_t size = std::size_t(state.range(0));
  std::vector<std::byte> message(size + kMacTrailerBytes);
  mac.write("HEIGHT_MAP_TILES", std::span(message).first(size), std::span(message).last<kMacTrailerBytes>());
  for (auto _ : state) {  // repeated but for the first: the hash is computed all the same
    std::span<const std::byte> view(message);
    benchmark::DoNotOptimize(check.open("HEIGHT_MAP_TILES", view));
  }
  state.SetBytesProcessed(state.iterations() * state.range(0));
}

BENCHMARK(write_mac)->Arg(100)->Arg(10'000)->Arg(60'000);
BENCHMARK(check)->Arg(100)->Arg(10'000)->Arg(60'000);

}  // namespace
