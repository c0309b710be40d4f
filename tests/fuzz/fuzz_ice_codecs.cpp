// Passes any bytes to the codecs of the path printer's instruments: an accepted message is written as it was
// read, and the ends of frames do not depend on the number of bytes that arrive at a time.
#include <cmath>
#include <cstring>

#include "drivers/heater/thermostat.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "tests/fuzz/require.h"
#include "tests/support/thermostat_box.h"
#include "tests/support/valve_firmware.h"

using namespace firn;
using namespace firn::fuzz;
using namespace firn::drivers;

namespace {

// Kinds and sizes of the frames, when `step` bytes arrive at a time.
std::vector<std::size_t> frames(const Dialect& dialect, const Request* awaited,
                                std::span<const std::byte> bytes, std::size_t step) {
  std::vector<std::byte> held;
  std::vector<std::size_t> found;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    const auto part = bytes.subspan(at, std::min(step, bytes.size() - at));
    held.insert(held.end(), part.begin(), part.end());
    while (!held.empty()) {
      const Frame f = dialect.frame(held, awaited);
      if (f.kind == Frame::Kind::kIncomplete) break;
      require(f.size > 0 && f.size <= held.size(), "a frame has a size within the buffer");
      if (f.kind != Frame::Kind::kCorrupt) found.push_back(std::size_t(f.kind) << 32 | f.size);
      held.erase(held.begin(), held.begin() + std::ptrdiff_t(f.size));
    }
  }
  return found;
}

void robot(std::span<const std::byte> bytes) {
  const fvp::Message m = fvp::parse(text_of(bytes));
  if (m.kind == fvp::Message::Kind::kBad) return;
  WordReader words(m.text);
  words.word();
  if (const auto s = fvp::parse_status(words)) {
    LineWriter line = fvp::request(1, "ACK");
    fvp::put(line, *s);
    WordReader again(line.so_far().substr(6));
    require(!line.overflow() && fvp::parse_status(again) == *s, "a status is written as it was read");
  }
  WordReader numbers(m.text);
  if (const auto c = fvp::parse_counts(numbers))
    require(fvp::counts_of(fvp::joints_of(*c)) == *c, "joints come back as they were");
}

void valve(std::span<const std::byte> bytes) {
  const fvb::Found f = fvb::find(bytes);
  if (f.kind != fvb::Found::Kind::kFrame) return;
  std::vector<std::byte> again;
  fvb::encode(f.type, f.seq, f.payload, again);
  require(again.size() == f.size && std::equal(again.begin(), again.end(), bytes.begin()),
          "a frame is written as it was read");
  if (const auto s = fvb::parse_status(f.payload)) {
    again.clear();
    fvb::encode(1, *s, again);
    require(fvb::parse_status(fvb::find(again).payload) == *s, "a status is written as it was read");
  }
  (void)fvb::parse_reply(f);
  (void)fvb::parse_hello(f.payload);
  (void)fvb::parse_begin(f.payload);
  if (const auto d = fvb::parse_data(f.payload))
    for (std::size_t n = 0; n < d->entries; ++n) (void)d->tick(n);
}

void laser(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  const lkg::Value v = lkg::parse_value(text);
  require((v.status == lkg::Status::kOk) == std::isfinite(v.mm),
          "a value is a number exactly where it is good");
  std::vector<float> mm;
  const auto damaged = lkg::parse_dump(text, mm);
  if (damaged)
    require(*damaged >= 0 && mm.size() == (text.size() + 1) / 9,
            "a dump has as many values as its bytes say");
  (void)lkg::parse_stored(text);
  for (const char* command : {"M1", "SW,CA,5", "AO,1", "R0"}) (void)lkg::parse(text, command);
}

void heater(std::span<const std::byte> bytes) {
  const auto r = thermostat::parse_reading(text_of(bytes));
  if (!r) return;
  LineWriter line;
  put(line, *r);
  const auto again = thermostat::parse_reading(line.so_far());
  require(again && again->heating == r->heating, "a reading is written as it was read");
  for (std::size_t c = 0; c < 3; ++c)
    require(std::isnan(r->celsius[c]) ? std::isnan(again->celsius[c]) : again->celsius[c] == r->celsius[c],
            "temperatures come back as they were");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::span<const std::byte> bytes = as_bytes(data + 2, size - 2);
  const std::size_t step = 1 + data[1] % 50;
  const fvp::FvpDialect fvp_dialect;
  const fvb::FvbDialect fvb_dialect;
  const lkg::LkgDialect lkg_dialect;
  const thermostat::ThermostatDialect thermostat_dialect;
  const Dialect* dialects[] = {&fvp_dialect, &fvb_dialect, &lkg_dialect, &thermostat_dialect};
  const Dialect& dialect = *dialects[data[0] % 4];
  const Request asked = dialect.probe();
  // Lines without an end are given up at different places; a whole frame is a frame in any case.
  const bool ended = data[0] % 4 == 1 || bytes.size() < 60;
  for (const Request* awaited : {static_cast<const Request*>(nullptr), &asked}) {
    const auto all = frames(dialect, awaited, bytes, step), one = frames(dialect, awaited, bytes, 1);
    if (ended) require(all == one, "frames do not depend on how the bytes arrive");
  }
  switch (data[0] % 4) {
    case 0:
      robot(bytes);
      break;
    case 1:
      valve(bytes);
      break;
    case 2:
      laser(bytes);
      break;
    default:
      heater(bytes);
  }
  return 0;
}
