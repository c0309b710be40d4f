// Any bytes as the payload of a write-ahead record: what decodes encodes back to the same bytes, views lie in
// the payload, and the rest is refused with its byte. The first byte chooses head, event or outputs.
#include "runtime/write_ahead.h"

#include <algorithm>
#include <stdexcept>

#include "files/record/record_file.h"
#include "runtime/wal_file.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const auto payload = as_bytes(data + 1, size - 1);
  std::vector<std::byte> again;
  try {
    if (data[0] % 3 == 0) {
      const WalHead head = decode_head(payload);
      encode_head(head, again);
      require(again.size() <= payload.size(), "a head holds no more than its payload");
      require(!config_message(head).empty(), "a head gives a CONFIG message");
    } else if (data[0] % 3 == 1) {
      const WalEvent e = decode_event(payload);
      require(lies_in(e.event.bytes, payload), "an event's bytes lie in the payload");
      describe(e.event);
      encode_event(e.step, e.event, again);
      require(again.size() <= payload.size() && std::equal(again.begin(), again.end(), payload.begin()),
              "an event encodes back to the same bytes");
    } else {
      const WalOutputs o = decode_outputs(payload);
      require(lies_in(o.body, payload), "outputs lie in the payload");
      for (const Output& each : decode_output_list(o.body))
        require(lies_in(each.bytes, payload), "an output's bytes lie in the payload");
    }
  } catch (const std::runtime_error& e) {
    require(std::string_view(e.what()).find("byte") != std::string_view::npos, "an error names the byte");
  }
  return 0;
}
