// Any bytes as a trajectory file, and as one record of it: the first byte chooses.
#include <cmath>

#include "files/path/trajectory_file.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

void check(const PlannedPath& path) {
  require(path.trajectory.positions.size() == path.trajectory.samples() * std::size_t(path.trajectory.axes),
          "whole samples");
  for (double v : path.trajectory.positions) require(std::isfinite(v), "positions are finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const auto bytes = as_bytes(data + 1, size - 1);
  try {
    if (data[0] % 2) {
      const TrajectoryHead head{"m", "certified", "fuzz", 0.016, {}, {"J1", "J2"}, {"rad", "rad"}};
      const PlannedPath path = decode_trajectory(bytes, head);
      check(path);
      const std::vector<std::byte> again = encode(path);
      require(encode(decode_trajectory(again, head)) == again, "what was read can be written and read again");
    } else {
      TrajectoryReader reader(bytes);
      while (const auto path = reader.next()) check(*path);
    }
  } catch (const TrajectoryFormatError&) {
  }
  return 0;
}
