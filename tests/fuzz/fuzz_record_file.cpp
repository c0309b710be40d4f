// Any bytes as a record file: indices rise, payloads lie inside, the valid end too.
#include "files/record/record_file.h"
#include "tests/fuzz/require.h"

using namespace firn::fuzz;
using namespace firn::record;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = as_bytes(data, size);
  firn::record::RecordReader reader(file);
  std::uint64_t next = 0;
  while (const auto r = reader.next()) {
    require(r->index >= next, "indices rise");
    next = r->index + 1;
    require(lies_in(r->payload, file), "payload lies in the file");
  }
  require(reader.valid_end() <= size, "valid end lies in the file");
  for (const firn::record::Damage& d : reader.damage().list())
    require(d.offset + d.bytes <= size, "damage lies in the file");
  return 0;
}
