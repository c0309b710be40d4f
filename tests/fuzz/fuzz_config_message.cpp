// Any text as the configuration of a CONFIG message: it goes through the message and back, and each node is
// made from it or refuses it in words. The first byte chooses the node.
#include <stdexcept>

#include "config/error.h"
#include "firn/config_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"
#include "runtime/wal_file.h"
#include "tests/fuzz/node_setups.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  static const std::vector<NodeSetup> setups = node_setups();
  const NodeSetup& setup = setups[data[0] % setups.size()];
  WalHead head;
  head.node = info(setup.id).name;
  head.run_id = 1;
  head.config_toml.assign(reinterpret_cast<const char*>(data + 1), size - 1);
  if (head.config_toml.find('\0') != head.config_toml.npos) return 0;  // LCM's texts end there
  const std::vector<std::byte> message = config_message(head);
  config_t back{};
  require(back.decode(message.data(), 0, int(message.size())) == int(message.size()), "the message is whole");
  require(back.config_toml == head.config_toml, "the configuration comes back");
  try {
    require(setup.make(back.config_toml, setup.run->inputs) != nullptr, "a node is made");
  } catch (const ConfigError&) {
  } catch (const std::invalid_argument&) {  // inputs of another grid than the configuration's
  } catch (const std::runtime_error&) {
  }
  return 0;
}
