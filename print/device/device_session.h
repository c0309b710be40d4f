// DeviceSession runs the node of one instrument alone, on its real port and without a bus: the driver, the
// limits, the lease and the stop are those of a print.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "files/port_address.h"
#include "firn/answer_t.hpp"
#include "firn/device_state_t.hpp"
#include "print/device/device_order.h"
#include "runtime/answering_node.h"
#include "runtime/node_host.h"
#include "runtime/ports.h"

namespace firn {

class DeviceSession {
 public:
  struct Sinks {
    std::function<void(const std::string& line)> tape;  ///< each line of a cassette (files/cassette.h)
    std::function<void(const std::string&)> note;  ///< a fault of the instrument, a port that does not open
    std::function<void(std::string_view channel, std::span<const std::byte>)> message;  ///< sent by the node
  };

  /// @throws std::runtime_error: the host of a TCP port is not known
  DeviceSession(NodeId id, std::unique_ptr<Node> node, const PortAddress& address, Sinks sinks);
  ~DeviceSession();

  /// Runs until `done`, at most `within_s`. @param interrupted asked at each turn @returns whether it is done
  bool run_until(const std::function<bool()>& done, double within_s,
                 const std::function<bool()>& interrupted = {});

  /// The instrument has been identified and is safe.
  bool safe() const;
  /// Time since the session began.
  double lasts_s() const { return double(now().us) * 1e-6; }
  /// Time since its first bytes, whatever they are; 0 before.
  double heard_for_s() const;
  /// It has given a good reply.
  bool answered() const { return answering_ && answering_->answered(); }
  /// Returns "; the last line that was not understood: 'A 1.2'"; empty: none.
  std::string not_understood() const;
  const std::optional<device_state_t>& state() const { return state_; }

  /// Gives the instrument an order; `text` is the person's.
  void command(const std::function<DeviceOrder(const OrderStamp&)>& order, const std::string& text);
  const std::optional<answer_t>& answer() const { return answer_; }  ///< to the last command

  /// Makes the instrument safe and waits for it. @returns whether it said so within 5 s
  bool stop(const std::string& cause);

 private:
  static constexpr std::int64_t kEpoch = 1;

  header_t header();
  Time now() const;
  void deliver(std::string_view channel, std::span<const std::byte> bytes);
  void step(const Event& event);
  void turn();

  const AnsweringNode* answering_;  ///< the node of host_
  NodeHost host_;
  Ports ports_;
  Sinks sinks_;
  std::int64_t began_us_ = 0, heard_us_ = 0, lease_us_ = 0, seq_ = 0, commands_ = 0;
  bool granted_ = true;
  std::optional<device_state_t> state_;
  std::optional<answer_t> answer_;
};

}  // namespace firn
