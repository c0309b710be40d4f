// Outbox holds the outputs of one step of a node. Nothing leaves before the step is over and its outputs are
// in the write-ahead file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid/device.h"
#include "core/grid/figure.h"
#include "lcmtypes/channels.h"
#include "runtime/event.h"

namespace firn {

class Outbox {
 public:
  Outbox(NodeId node, std::int64_t run_id) : node_(node), run_id_(run_id) {}

  /// Stamps the header (run, incarnation, next sequence number of the channel, now) and encodes.
  /// @throws std::logic_error if this node is not the publisher of the channel.
  template <class Message>
  void send(const Channel<Message>& channel, Message message) {
    stamp(channel.name, message.header);
    const int size = message.getEncodedSize();
    const std::span<std::byte> place = reserve(std::size_t(size));
    if (message.encode(place.data(), 0, size) != size)
      throw std::logic_error("cannot encode " + std::string(channel.name));
    push_send(channel.name, place.size());
  }

  /// Sends a fault_t of this node.
  void report(Severity severity, std::string text, std::int32_t code = 0, const Figure& figure = {});
  void warn(std::string text);           ///< the same with severity kWarning
  void wake_at(TimerId timer, Time at);  ///< arms or moves the timer
  void cancel(TimerId timer);
  void write(PortId port, std::span<const std::byte> bytes);  ///< bytes for an instrument; drivers only
  void reopen(PortId port);                                   ///< close the port and connect again
  /// Everything of this step must be on the disk (fdatasync) before any of it leaves: call it where a
  /// physical act depends on the record.
  void durable() { durable_ = true; }
  /// This node's work in the run is over; exit status and reason go to the launcher.
  void finish(int status, std::string_view reason);

  /// Numbering of `channel` goes on behind `seq`: for a publisher that is no replayed node and comes back.
  void resume_after(std::string_view channel, std::int64_t seq);

  // For the host only.
  void begin(Time now, std::int32_t incarnation);
  std::size_t size() const { return entries_.size(); }
  bool empty() const { return entries_.empty(); }
  bool wants_durable() const { return durable_; }
  Output at(std::size_t n) const;
  NodeId node() const { return node_; }
  std::int64_t run_id() const { return run_id_; }
  Time now() const { return now_; }

 private:
  struct Entry {
    OutputKind kind;
    std::string_view channel;
    std::uint32_t id;
    Time at;
    std::size_t offset, size;
  };
  template <class Header>
  void stamp(std::string_view channel, Header& header) {
    header.run_id = run_id_;
    header.incarnation = incarnation_;
    header.seq = next_seq(channel);
    header.utime_us = now_.us;
  }
  std::int64_t next_seq(std::string_view channel);
  std::span<std::byte> reserve(std::size_t size);
  void push_send(std::string_view channel, std::size_t size);
  void push(OutputKind kind, std::string_view channel, std::uint32_t id, Time at,
            std::span<const std::byte> bytes);

  NodeId node_;
  std::int64_t run_id_;
  std::int32_t incarnation_ = 0;
  Time now_;
  bool durable_ = false;
  std::vector<Entry> entries_;
  std::vector<std::byte> arena_;
  std::map<std::string_view, std::int64_t> last_seq_;  // keys point into the channel table
};

}  // namespace firn
