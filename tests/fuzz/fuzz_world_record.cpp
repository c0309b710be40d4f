// Any records of the world: what is taken has the length of its kind, the rest is refused. Input: {kind, u8
// length, payload}…
#include "plant/record/record.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  plant::WorldHistory h;
  std::size_t taken = 0;
  for (std::size_t at = 0; at + 2 <= size;) {
    const std::size_t n = std::min<std::size_t>(data[at + 1], size - at - 2);
    if (plant::decode(plant::RecordKind(data[at] % 10), as_bytes(data + at + 2, n), h)) taken += n;
    at += 2 + n;
  }
  require(
      h.begins.size() * sizeof(plant::BeginRecord) + h.shots.size() * sizeof(plant::ShotRecord) +
              h.scans.size() * sizeof(plant::ScanRecord) + h.lamp.size() * sizeof(plant::LampRecord) +
              h.links.size() * sizeof(plant::LinkRecord) + h.devices.size() * sizeof(plant::DeviceRecord) +
              h.firings.size() * sizeof(plant::FiringRecord) + h.truths.size() * sizeof(plant::TruthRecord) ==
          taken,
      "records have the bytes that were taken");
  return 0;
}
