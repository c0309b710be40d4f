#include <catch2/catch.hpp>  // of tests/print/ice_runs.h

#include "tests/firmware/program_print.h"

#include "tests/firmware/avr_valve.h"

namespace firn::test {

void with_binaries(plant::WorldConfig& config) {
  config.ice.make_valve_box = [](int valve, const plant::IceValveParams& params, plant::IceWires& wires) {
    return std::make_unique<AvrValve>(FIRN_VALVE_ELF, valve, params, wires);
  };
}

}  // namespace firn::test
