// OperatorDesk takes the operator's orders while a print runs: from firn ctl and firn attach over the Unix
// socket RUN/operator, and from the keys of the print's own terminal.
#pragma once

#include <poll.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/changes.h"
#include "firn/layer_metrics_t.hpp"
#include "print/operator/key_reader.h"
#include "print/operator/operator_order.h"

namespace firn {

/// A client sends lines, "ID VERB [KEY=VALUE]", "attach", "run RUN_ID", which says for which run its orders
/// are, "from NAME", which names it in the record of its orders, or "own ORDER" (own_print.h). Every order is
/// answered by "ok TEXT" or "refused TEXT"; "stop" is answered when the safety node has stopped the lab;
/// "state" is answered by "state running", "state pausing" or "state paused: TEXT". An attached client gets
/// "layer ...", "note TEXT" and, last, "end STATUS". Only the user who prints may connect. A new client
/// always finds a place: the desk hears out the one that has been silent for longest and closes it, one that
/// awaits a stop last.
class OperatorDesk {
 public:
  /// Publishes an order. @param from "firn ctl", "key", "page"
  using Obey = std::function<void(const OperatorOrder&, const std::string& from)>;
  using Note = std::function<void(const std::string&)>;

  /// Carries out "key NAME" and "say NAME CHANNEL JSON" of the lab's own programs. @returns the answer
  using Own = std::function<std::string(const std::string& order)>;
  void take_own(Own own) { own_ = std::move(own); }

  static constexpr std::size_t kPlaces = 16;  ///< for clients

  /// @param run_id orders for another run are refused
  /// @param note gets the answers to keys, and the reason if there is no socket
  OperatorDesk(const std::filesystem::path& run, std::int64_t run_id, const Experiment& experiment,
               Note note);
  ~OperatorDesk();
  OperatorDesk(const OperatorDesk&) = delete;
  OperatorDesk& operator=(const OperatorDesk&) = delete;

  /// Remembers an order that this print was given before its resume, or with it: its number is used, its
  /// change holds.
  void remember(const OperatorOrder& order);

  void add_to(std::vector<pollfd>& fds) const;
  /// Takes the lines that have arrived; does not block.
  void service(const Obey& obey);
  /// Waits at most this long for something to arrive.
  void wait(int milliseconds) const;
  void on_safe_stop();  ///< answers those who sent "stop"
  void tell(const std::string& line);
  void tell(const layer_metrics_t& metrics);

 private:
  struct Client {
    int fd = -1;
    std::string buffer, name = "firn ctl", run_id;
    bool attached = false, awaits_stop = false;
    std::uint64_t heard = 0;  // by the count of lines, and of clients, that have come
  };
  void accept_clients(const Obey&);
  void make_room(const Obey&);
  void read(Client&, const Obey&);
  void take(Client&, const std::string& line, const Obey&);
  void require_this_run(const Client&) const;
  std::string obey_line(Client&, const std::string& line, const Obey&);
  std::string obey_order(const OperatorOrder&, const std::string& from, const Obey&);
  void take_keys(const Obey&);

  std::filesystem::path path_;
  std::int64_t run_id_;
  Changes changes_;
  struct Taken {
    std::string text;
    bool earlier = false;  // before the resume
  };
  std::map<std::int64_t, Taken> taken_;  // orders by their number
  Note note_;
  Own own_;
  int listening_ = -1;
  bool stopped_ = false;
  bool pausing_ = false;  // a pause was asked for last, not its end
  std::string waits_;     // the scheduler's notice of a pause; empty: the print runs
  std::vector<Client> clients_;
  std::uint64_t heard_ = 0;
  KeyReader keys_;
};

/// The line of an attached client about a layer.
std::string layer_line(const layer_metrics_t& metrics);
std::optional<layer_metrics_t> parse_layer_line(const std::string& line);

std::filesystem::path operator_socket(const std::filesystem::path& run);

}  // namespace firn
