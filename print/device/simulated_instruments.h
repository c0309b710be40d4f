// SimulatedInstruments runs the world of a lab in a process of its own, so that one instrument can be tried
// without hardware.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "files/port_address.h"
#include "files/temporary_folder.h"
#include "print/process/child_process.h"

namespace firn {

class SimulatedInstruments {
 public:
  /// @param quick they start without delay: a JetDrive's RESET takes 3 s
  /// @throws std::runtime_error: the program `world` is neither beside this one nor in ../bin, or does not
  /// begin
  explicit SimulatedInstruments(const Experiment& experiment, bool quick = false);
  ~SimulatedInstruments();  ///< ends the world and removes its folder
  SimulatedInstruments(const SimulatedInstruments&) = delete;
  SimulatedInstruments& operator=(const SimulatedInstruments&) = delete;

  PortAddress address(const std::string& node) const;
  /// Injects a fault: "PORT KIND [COUNT [DELAY_US]]" (plant/twins/fault.h).
  void inject(const std::string& fault);
  /// Reads the balance under an ice lab's cup. @throws std::runtime_error: the world does not answer
  double weighed_mg(int material, int weighing);

 private:
  TemporaryFolder folder_;  // outlives the world
  std::unique_ptr<ChildProcess> world_;
};

}  // namespace firn
