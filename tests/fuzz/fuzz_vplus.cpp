// Passes any text to the V+ interpreter: it is refused with a reason that names its line, or it is executed,
// and then a tick never takes more statements than its budget and a saved machine goes on as it would have.
#include <stdexcept>

#include "plant/twins/vplus/machine.h"
#include "tests/fuzz/require.h"
#include "tests/plant/still_arm.h"

using namespace firn::fuzz;
using namespace firn::plant;
using namespace firn::plant::vplus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Code code;
  try {
    code = parse({{"fuzz.v2", std::string(reinterpret_cast<const char*>(data), size)}});
  } catch (const std::invalid_argument& e) {
    require(std::string_view(e.what()).starts_with("fuzz.v2:"), "a refusal names file and line");
    return 0;
  }
  StillArm arm;
  constexpr int kBudget = 320;
  Machine machine(code, arm, {.statements_per_tick = kBudget});
  for (const auto& [name, number] : code.program_of)
    if (code.programs[number].parameters == 0) {
      machine.execute(0, name, 0);
      break;
    }
  machine.network().connected();
  machine.network().arrived("@1 HELLO FIRN 1*0000\r\n");
  constexpr std::int64_t kTicks = 4, kTick_us = 16'000;
  run_until(machine, kTicks * kTick_us - 1);
  require(machine.statements() <= kTicks * kBudget, "a tick has a budget of statements");
  (void)machine.take_written();
  Archive saved;
  machine.io(saved);
  Machine restored(code, arm, {.statements_per_tick = kBudget});
  Archive loaded(saved.bytes());
  restored.io(loaded);
  for (Machine* m : {&machine, &restored}) run_until(*m, 2 * kTicks * kTick_us);
  Archive a, b;
  machine.io(a);
  restored.io(b);
  require(a.bytes() == b.bytes(), "a restored machine goes on as the one that was saved");
  return 0;
}
