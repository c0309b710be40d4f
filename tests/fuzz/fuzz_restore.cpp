// Brings each node back from any write-ahead records with true checksums and step numbers: the node takes
// each event or restore() refuses the file in words. The first byte chooses the node; records follow as
// {kind, u16 length, payload}.
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "files/usage_error.h"
#include "runtime/wal_file.h"
#include "tests/fuzz/node_setups.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

const std::filesystem::path& scratch_file() {
  static const std::filesystem::path file = "/dev/shm/firn-fuzz-restore-" + std::to_string(::getpid());
  return file;
}

// Step numbers count up as a host writes them: no fuzzer guesses eight bytes.
void write_records(const std::uint8_t* at, const std::uint8_t* end) {
  std::filesystem::remove(scratch_file());
  WalFile file(scratch_file(), false, 1 << 16);
  std::uint64_t steps = 0;
  while (end - at >= 3) {
    const auto kind = WalKind(1 + at[0] % 3);
    const std::size_t n = std::min<std::size_t>(std::size_t(at[1] | at[2] << 8), std::size_t(end - at) - 3);
    std::vector<std::byte> payload(n);
    if (n > 0) std::memcpy(payload.data(), at + 3, n);
    const std::uint64_t step = kind == WalKind::kEvent ? steps++ : steps - 1;
    if (kind != WalKind::kHead && n >= sizeof step) std::memcpy(payload.data(), &step, sizeof step);
    file.append(kind, payload);
    at += 3 + n;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  static const std::vector<NodeSetup> setups = node_setups();
  const NodeSetup& setup = setups[data[0] % setups.size()];
  // The planner plans all paths when it starts, for a third of a second: seldom.
  if (setup.id == NodeId::kPathPlanner && data[0] < 255 - setups.size()) return -1;
  write_records(data + 1, data + size);
  NodeHost host(setup.id, setup.make(setup.run->config_toml, setup.run->inputs), setup.run->run_id, nullptr);
  RestoreSinks sinks;
  sinks.head = [](const WalHead&) {};
  sinks.received = sinks.sent = sinks.unsent = [](std::string_view channel, std::span<const std::byte>) {
    require(!channel.empty(), "a message has a channel");
  };
  try {
    WalFile file(scratch_file(), true, 1 << 16);
    restore(host, setup.run->run_id, file, sinks);
  } catch (const std::runtime_error& e) {
    require(*e.what() != 0, "an error has words");
  }
  return 0;
}
