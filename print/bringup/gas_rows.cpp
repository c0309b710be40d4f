// Rows of the mass-flow controllers: who they are, and whether a flow follows its set point.
#include <cmath>

#include "drivers/gas/alicat.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

using drivers::alicat::Reading;

constexpr double kLowest_kpa = 80.0, kColdest_degC = 5.0, kWarmest_degC = 50.0;
constexpr double kClosed = 0.002;  // of the full scale

struct BothReadings {
  std::string text[2];  ///< Reading::gas is part of it
  Reading reading[2];
};

/// The unit's own answer; before it may come late ones to the driver that had the line.
std::string_view own_answer(std::string_view heard, const drivers::Request& asked) {
  using drivers::Frame;
  const drivers::alicat::AlicatDialect dialect;
  while (!heard.empty()) {
    const Frame f = dialect.frame(bytes_of(heard), &asked);
    if (f.kind == Frame::Kind::kReply) return heard.substr(0, f.size);
    if (f.kind == Frame::Kind::kIncomplete) break;
    heard.remove_prefix(f.size);
  }
  return {};
}

BothReadings both_controllers(BringupLab& lab, const std::string& node) {
  using namespace drivers;
  BothReadings both;
  const std::string units[] = {lab.e.gas.atomizer_unit, lab.e.gas.sheath_unit};
  const auto line = lab.line(node);
  for (std::size_t n = 0; n < 2; ++n) {
    const Request asked = alicat::poll_request({units[n][0], false}, 0);
    const std::string heard =
        line->ask(asked.text(), [&](std::string_view s) { return !own_answer(s, asked).empty(); });
    const std::string_view own = own_answer(heard, asked);
    both.text[n] = own.empty() ? heard : own;
    const auto r = alicat::parse_reading(alicat::text_of(bytes_of(both.text[n])));
    if (!r || own.empty())
      throw BringupStop("unit " + units[n] + " answers '" + both.text[n].substr(0, 60) +
                        "': its letter at its panel, gas.atomizer_unit, gas.sheath_unit");
    both.reading[n] = *r;
  }
  return both;
}

BringupFinding gas_readings(BringupLab& lab, const std::string& node) {
  const BothReadings both = both_controllers(lab, node);
  const drivers::GasDialect& d = lab.e.gas.dialect;
  bool ok = true;
  std::string measured, mend;
  for (const Reading& r : both.reading) {
    const double kpa = r.pressure * d.kpa_per_unit;
    measured += (measured.empty() ? "" : "; ") + std::string(1, r.unit) + ": " + number_text(kpa) + " kPa, " +
                number_text(r.temperature_degC) + " degC, " + std::string(r.gas);
    if (r.gas != lab.e.gas.gas) mend = "select the gas at the panel, or gas.gas";
    if (!(r.temperature_degC > kColdest_degC && r.temperature_degC < kWarmest_degC))
      mend = "its temperature is shown in another unit, or it is broken";
    if (!(kpa > kLowest_kpa && kpa < lab.e.gas.most_pressure_kpa))
      mend = "devices.gas.dialect.kpa_per_unit is not the display's unit, or the nozzle is clogged";
    ok = ok && mend.empty();
  }
  return {ok, measured,
          lab.e.gas.gas + ", " + number_text(kLowest_kpa) + " to " +
              number_text(lab.e.gas.most_pressure_kpa) + " kPa, " + number_text(kColdest_degC) + " to " +
              number_text(kWarmest_degC) + " degC",
          mend};
}

BringupFinding sheath_follows(BringupLab& lab, const std::string& node) {
  const GasConfig& g = lab.e.gas;
  if (const std::string why = lab.drive(node, "set", {0.0, g.sheath_sccm}); !why.empty())
    return {false, why, "the sheath's flow", "bottle, its valve, the tube; set point source: digital"};
  const BothReadings both = both_controllers(lab, node);
  const double atomizer = both.reading[0].mass_flow * g.dialect.sccm_per_unit,
               sheath = both.reading[1].mass_flow * g.dialect.sccm_per_unit;
  lab.drive(node, "set", {0.0, 0.0});
  const bool follows = std::abs(sheath - g.sheath_sccm) <= g.tolerance * g.sheath_sccm,
             closed = std::abs(atomizer) <= kClosed * g.atomizer_max_sccm;
  return {follows && closed,
          "sheath " + number_text(sheath) + " sccm, atomizer " + number_text(atomizer) + " sccm",
          number_text(g.sheath_sccm) + " sccm, none",
          follows ? "the atomizer's valve leaks, or its zero is off: tare it at its panel"
                  : "devices.gas.dialect.sccm_per_unit is not the display's unit"};
}

constexpr BringupRow kGasRows[] = {
    {52, "gas", "both units show a believable pressure, temperature and their gas",
     "gas.gas, devices.gas.dialect.kpa_per_unit", &gas_readings},
    {53, "gas", "the sheath follows its set point, and the atomizer's valve is closed",
     "devices.gas.dialect.sccm_per_unit", &sheath_follows},
    {54, "gas", "the sheath's pressure is that behind the nozzle: it rises where the outlet is held shut",
     "gas.most_pressure_kpa"},
};

}  // namespace

std::span<const BringupRow> gas_rows() { return kGasRows; }

}  // namespace firn
