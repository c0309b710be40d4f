// Any bytes from the relay of another host: frames that lie in them, or one refusal; and a hello that reads
// back to itself. Cut into pieces the stream gives the same frames.
#include <algorithm>
#include <string>
#include <vector>

#include "procs/relay/hello.h"
#include "runtime/relay/frame.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

std::vector<std::byte> frames_again(std::span<const std::byte> stream, std::size_t piece) {
  relay::FrameReader reader;
  std::vector<std::byte> again;
  try {
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      reader.add(stream.subspan(at, std::min(piece, stream.size() - at)));
      while (const auto f = reader.next()) relay::append_frame(*f, again);
    }
  } catch (const std::runtime_error&) {
  }
  return again;
}

void check_hello(std::string_view text) try {
  const relay::Hello hello = relay::hello_from_json(std::string(text));
  require(to_json(relay::hello_from_json(to_json(hello))) == to_json(hello), "a hello reads back to itself");
} catch (const std::invalid_argument&) {
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto stream = as_bytes(data, size);
  const auto whole = frames_again(stream, size + 1);
  require(whole.size() <= size && std::equal(whole.begin(), whole.end(), stream.begin()),
          "frames are the bytes of the stream");
  require(frames_again(stream, 3) == whole, "pieces of the stream give the same frames");
  check_hello({reinterpret_cast<const char*>(data), size});
  relay::FrameReader reader;
  reader.add(stream);
  try {
    while (const auto f = reader.next())
      if (f->kind == relay::FrameKind::kHello) check_hello(f->text());
  } catch (const std::runtime_error&) {
  }
  return 0;
}
