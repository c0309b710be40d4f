// Passes any bytes to the heaters' firmware as lines of its host, and some of them as words of its
// converters: each reply is a whole line, and no relay is on where the temperature is unknown, too high or at
// its set point.
#include <string_view>

#include "drivers/link/checked_line.h"
#include "firmware/heater/heater.h"
#include "tests/fuzz/require.h"

using namespace firn::fuzz;

namespace {

void hold(const heater& h) {
  require(h.line_size <= HEATER_MAX_LINE && h.reply_size <= HEATER_MAX_REPLY, "lines fit");
  for (const heater_channel& c : h.channel) {
    require(c.set_cdegC >= HEATER_OFF_CDEGC && c.set_cdegC <= HEATER_HIGHEST_CDEGC,
            "a set point in its range");
    require(c.shown_cdegC >= HEATER_LOWEST_READ_CDEGC && c.shown_cdegC <= HEATER_HIGHEST_READ_CDEGC,
            "a temperature that is believed");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  heater h{};
  heater_init(&h, HEATER_HIGHEST_CDEGC);
  std::uint32_t word = 0;
  for (std::size_t n = 0; n < size; ++n) {
    heater_receive(&h, data[n]);
    hold(h);
    require((h.reply_size > 0) == (data[n] == '\n'), "each line is answered, and nothing else");
    if (h.reply_size > 0) {
      const std::string_view reply(reinterpret_cast<const char*>(h.reply), h.reply_size);
      require(firn::drivers::checked_text(reply, 0).has_value(), "a reply is a whole line");
    }
    word = word << 8 | data[n];
    if (data[n] % 8 != 0) continue;
    heater_read(&h, std::uint8_t(n % 4), word);
    heater_tick(&h);
    hold(h);
    for (const heater_channel& c : h.channel)
      require(!c.relay || (!c.open && !c.cut_out && c.shown_cdegC < c.set_cdegC + HEATER_HYSTERESIS_CDEGC),
              "a relay is on for a reason");
  }
  return 0;
}
