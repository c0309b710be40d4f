// Hardware is the ink-jet lab as instruments at ports: a world's process of its own, behind TCP and serial
// lines.
#pragma once

#include <sys/types.h>

#include <memory>

#include "config/experiment.h"
#include "plant/record/record.h"
#include "tests/live/port_bridge.h"
#include "tests/support/temp_folder.h"

namespace firn::test {

class Hardware {
 public:
  explicit Hardware(const Experiment& e);
  ~Hardware() { stop(); }
  void start();
  void stop();
  /// Stage and profiler at TCP ports, jet and lamp at serial lines. @param lamp false: it stays simulated
  void connect(Experiment& e, bool lamp = true) const;
  plant::WorldHistory history() const { return plant::read_history(folder_.path() / "world.rec"); }

 private:
  TempFolder folder_;
  pid_t pid_ = -1;
  std::unique_ptr<PortBridge> stage_, profiler_, jet_, lamp_;
};

}  // namespace firn::test
