// Node is a pure state machine that does the work of one process: the same class runs live, in the in-process
// Lab and in replay, and never knows in which. It never reads a clock, opens a file or starts a thread.
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/channels.h"
#include "runtime/outbox.h"
#include "runtime/time.h"

namespace firn {

struct Start {
  std::int32_t incarnation = 0;
  bool resumed() const { return incarnation > 0; }
};

class Node {
 public:
  virtual ~Node() = default;

  /// First event of every incarnation: all processes are ready. A driver connects here.
  virtual void start(const Start&, Time /*now*/, Outbox&) {}
  virtual void wake(TimerId, Time /*now*/, Outbox&) {}
  /// Drivers only: bytes from the instrument at `port`, in any split.
  virtual void on_io(PortId, std::span<const std::byte>, Time /*now*/, Outbox&) {}
  /// Drivers only: the port was opened or has closed.
  virtual void on_link(PortId, LinkState, Time /*now*/, Outbox&) {}

  /// Drivers only: do the bytes that the last step put out for a port belong to a command, which only a lease
  /// lets out?
  virtual bool writes_need_lease() const { return false; }
  /// Drivers only: why such bytes must not leave at `now`; empty: they may. It is asked right before they
  /// leave, since time has passed while the step was written to the disk.
  /// @param stop_epoch of the newest SAFE_STOP that waits to be handled; 0 = none waits
  virtual std::string lease_refusal(Time /*now*/, std::int64_t /*stop_epoch*/) const { return {}; }
  /// Drivers only: the bytes that the step before put out for this port have not left, and will not.
  virtual void on_refused(PortId, std::string_view /*cause*/, Time /*now*/, Outbox&) {}

  /// This process must become safe on its own (its launcher is gone or said so): a driver makes its
  /// instrument safe, safety raises the epoch.
  virtual void local_stop(std::string_view /*cause*/, Time /*now*/, Outbox&) {}

  /// Names of the instrument ports, index = PortId. Empty for all but drivers.
  virtual std::vector<std::string> ports() const { return {}; }

  /// One subscription: decodes, then calls `on(const Message&, Time, Outbox&)` of the node. Returns false
  /// when the bytes do not decode.
  struct Route {
    std::string_view channel;
    std::function<bool(std::span<const std::byte>, Time, Outbox&)> deliver;
  };
  const std::vector<Route>& routes() const { return routes_; }

 protected:
  /// In the constructor: `subscribe(channels::kHeightMap, this)`. A node without a matching `on` does not
  /// compile.
  template <class Message, class Self>
  void subscribe(const Channel<Message>& channel, Self* self) {
    routes_.push_back({channel.name, [self, message = Message{}](std::span<const std::byte> bytes, Time now,
                                                                 Outbox& out) mutable {
                         if (message.decode(bytes.data(), 0, int(bytes.size())) != int(bytes.size()))
                           return false;
                         self->on(static_cast<const Message&>(message), now, out);
                         return true;
                       }});
  }

 private:
  std::vector<Route> routes_;
};

/// Inputs of a run by role ("target", "mask", …): the bytes of files under inputs/<sha256>.
struct Blob {
  std::string role;
  std::string sha256;
  std::vector<std::byte> bytes;
};
using Blobs = std::vector<Blob>;

/// @throws std::invalid_argument naming the role if it is missing.
const Blob& blob(const Blobs& blobs, std::string_view role);

/// Returns a resolved configuration (text of `dump`) without its tables [plant] and [plant.…]: the simulated
/// truth and its seed are none of a node's business.
std::string without_plant(const std::string& config_toml);

/// MakeNode builds a node from the resolved configuration and the run's inputs, live and in replay alike. The
/// node is handed the configuration without [plant].
class MakeNode {
 public:
  using Function = std::unique_ptr<Node> (*)(const std::string& config_toml, const Blobs& blobs);
  constexpr MakeNode(std::convertible_to<Function> auto make) : make_(make) {}
  std::unique_ptr<Node> operator()(const std::string& config_toml, const Blobs& blobs) const {
    return make_(without_plant(config_toml), blobs);
  }

 private:
  Function make_;
};

}  // namespace firn
