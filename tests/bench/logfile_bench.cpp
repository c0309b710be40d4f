// Measures the speed of writing and reading log and write-ahead bytes, and the cost of the check of a
// received message. Files go to FIRN_BENCH_DIR, by default the system's temporary folder: name a real disk to
// measure one.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdlib>

#include "files/record/event_log.h"
#include "files/record/record_file.h"
#include "lcmtypes/schema.h"
#include "lcmtypes/validate.h"
#include "tests/files/record/scratch.h"
#include "tests/lcmtypes/samples.h"

namespace {

using namespace firn;
using namespace firn::record;
using firn::test::encode;

std::filesystem::path bench_file(const char* name) {
  const char* dir = std::getenv("FIRN_BENCH_DIR");
  const auto path = (dir ? std::filesystem::path(dir) : std::filesystem::temp_directory_path()) / name;
  for (const char* suffix : {"", ".idx"}) std::filesystem::remove(path.string() + suffix);
  return path;
}

void set_rates(benchmark::State& state, std::size_t payload_bytes) {
  state.SetItemsProcessed(state.iterations());
  state.SetBytesProcessed(state.iterations() * std::int64_t(payload_bytes));
}

constexpr std::int64_t kWrappedBytes = std::int64_t(2) << 30;  // then a new file

void event_writer(benchmark::State& state) {
  const std::vector<std::byte> data(std::size_t(state.range(0)), std::byte{42});
  const auto path = bench_file("firn-bench.lcm");
  auto writer = std::make_unique<record::EventLogWriter>(path);
  std::int64_t utime_us = 0;
  for (auto _ : state) {
    writer->append(++utime_us, "HEIGHT_PROFILE", data);
    if (std::int64_t(writer->bytes()) > kWrappedBytes) {
      state.PauseTiming();
      writer.reset();
      bench_file("firn-bench.lcm");
      writer = std::make_unique<record::EventLogWriter>(path);
      state.ResumeTiming();
    }
  }
  writer->close();
  set_rates(state, data.size());
  bench_file("firn-bench.lcm");
}
BENCHMARK(event_writer)->Arg(100)->Arg(1000)->Arg(4000)->Arg(60000)->Arg(640000);

void record_writer(benchmark::State& state) {
  const std::vector<std::byte> data(std::size_t(state.range(0)), std::byte{42});
  const auto path = bench_file("firn-bench.wal");
  auto writer = std::make_unique<record::RecordWriter>(path, record::RecordWriter::Mode::kCreate);
  for (auto _ : state) {
    writer->append(2, data);
    if (std::int64_t(writer->bytes()) > kWrappedBytes) {
      state.PauseTiming();
      writer.reset();
      bench_file("firn-bench.wal");
      writer = std::make_unique<record::RecordWriter>(path, record::RecordWriter::Mode::kCreate);
      state.ResumeTiming();
    }
  }
  set_rates(state, data.size());
  writer.reset();
  bench_file("firn-bench.wal");
}
BENCHMARK(record_writer)->Arg(100)->Arg(1000)->Arg(60000)->Arg(640000);

void event_reader(benchmark::State& state) {
  const std::vector<std::byte> data(std::size_t(state.range(0)), std::byte{42});
  const auto path = bench_file("firn-bench.lcm");
  {
    record::EventLogWriter writer(path);
    for (std::int64_t bytes = 0; bytes < 64'000'000; bytes += state.range(0))
      writer.append(bytes, "HEIGHT_PROFILE", data);
    writer.close();
  }
  const record::EventLogFile file(path);
  std::int64_t events = 0;
  for (auto _ : state) {
    record::EventLogReader reader = state.range(1) ? file.reader() : record::EventLogReader(file.bytes());
    while (const auto e = reader.next()) events += e->data.size() == data.size();
  }
  state.SetItemsProcessed(events);
  state.SetBytesProcessed(state.iterations() * std::int64_t(file.bytes().size()));
  state.SetLabel(state.range(1) ? "checked by the index" : "without index");
  bench_file("firn-bench.lcm");
}
BENCHMARK(event_reader)->ArgsProduct({{100, 4000, 640000}, {0, 1}});

void record_reader(benchmark::State& state) {
  const std::vector<std::byte> data(std::size_t(state.range(0)), std::byte{42});
  const auto path = bench_file("firn-bench.wal");
  {
    record::RecordWriter writer(path, record::RecordWriter::Mode::kCreate);
    for (std::int64_t bytes = 0; bytes < 64'000'000; bytes += state.range(0)) writer.append(2, data);
  }
  const record::MappedFile file(path);
  std::int64_t records = 0;
  for (auto _ : state) {
    record::RecordReader reader(file.bytes());
    while (reader.next()) ++records;
  }
  state.SetItemsProcessed(records);
  state.SetBytesProcessed(state.iterations() * std::int64_t(file.bytes().size()));
  bench_file("firn-bench.wal");
}
BENCHMARK(record_reader)->Arg(100)->Arg(4000)->Arg(640000);

void validate_message(benchmark::State& state, const char* channel, const std::vector<std::byte>& message) {
  const ChannelInfo& info = *find_channel(channel);
  for (auto _ : state) benchmark::DoNotOptimize(validate(info, message));
  set_rates(state, message.size());
}
BENCHMARK_CAPTURE(validate_message, jet_command, "JET_COMMAND", [] {
  jet_command_t m{};
  m.header = test::some_header();
  m.verb = 1;
  return encode(m);
}());
BENCHMARK_CAPTURE(validate_message, heartbeat, "HEARTBEAT_JET", encode(test::some_heartbeat()));
BENCHMARK_CAPTURE(validate_message, height_map_40x40, "HEIGHT_MAP", encode(test::some_height_map(40, 40)));
BENCHMARK_CAPTURE(validate_message, layer_plan_100x100, "LAYER_PLAN",
                  encode(test::some_layer_plan(100, 100)));

}  // namespace
