// CommandThread passes a browser's orders on to the prints, before all other work of the page: a safe stop
// waits for no file, map or watcher, and for no other print.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "page/client_frame.h"

namespace firn::page {

/// The print that an order is for.
struct OrderedRun {
  std::filesystem::path folder;
  std::int64_t run_id = 0;
  std::string person = {};  ///< who orders, for the record; empty: whoever has the page's token
};

class CommandThread {
 public:
  CommandThread();
  ~CommandThread();
  CommandThread(const CommandThread&) = delete;
  CommandThread& operator=(const CommandThread&) = delete;

  static constexpr const char* kProtocol = "firn";
  /// Takes a connection whose request named this protocol and the token. From any thread.
  /// @param fd of the connection, which it owns from now on @param request text of the upgrade
  void take(int fd, bool v6, std::string request, OrderedRun run);
  /// Passes one order on. From any thread. @param done gets the frame that answers it, on the thread for
  /// commands
  void obey(OrderedRun run, ClientFrame frame, std::function<void(std::string answer)> done);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Calls `run` until it returns: an error ends one connection or run, the others go on.
void run_through(const std::function<void()>& run);

}  // namespace firn::page
