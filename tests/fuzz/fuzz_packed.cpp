// Any bytes as a packed file beside a log, as squeezed records, and as a file to be packed. The first byte
// chooses. A packed file that opens packs and opens again with the same bytes.
#include "files/record/packed.h"
#include "files/record/squeeze.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/known_log.h"
#include "tests/fuzz/require.h"
#include "tests/support/temp_folder.h"

using namespace firn::fuzz;
using namespace firn::record;

namespace {

using Bytes = std::vector<std::byte>;

const std::filesystem::path& folder() {
  static const firn::test::TempFolder made;
  static const bool written = [] {
    std::ofstream(made.path() / "log.lcm") << kKnownLog;
    return true;
  }();
  require(written, "the log is there");
  return made.path();
}

Bytes unpacked(std::span<const std::byte> packed) {
  const firn::record::Pages pages = firn::record::unpack(folder() / "a.wal", packed);
  return {pages.span().begin(), pages.span().end()};
}

void packs_and_opens(std::span<const std::byte> plain) {
  const auto log = std::as_bytes(std::span(kKnownLog));
  require(std::ranges::equal(unpacked(firn::record::pack(plain, log, "log.lcm")), plain),
          "opens as it was packed");
}

void restores(std::span<const std::byte> squeezed, std::size_t bytes) {
  Bytes plain(bytes);
  if (!firn::record::restore_records(squeezed, plain)) return;
  Bytes again(bytes);
  require(firn::record::restore_records(firn::record::squeeze_records(plain), again),
          "what was restored squeezes and restores");
  require(again == plain, "squeezing keeps every byte");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const auto input = as_bytes(data, size);
  if (data[0] % 3 == 0) {
    try {
      packs_and_opens(unpacked(input.subspan(1)));
    } catch (const std::runtime_error& e) {
      const std::string_view what = e.what();
      require(what.find("a.wal") != what.npos || what.find("log.lcm") != what.npos,
              "an error names the file");
    }
  } else if (data[0] % 3 == 1) {
    restores(input.subspan(3), data[1] + 256u * data[2]);
  } else {
    packs_and_opens(input.subspan(1));
  }
  return 0;
}
