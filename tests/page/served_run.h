// Served serves a folder with one finished run, as firn view does, until it goes.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "page/server.h"
#include "tests/support/temp_folder.h"

namespace firn::test {

/// Prints in one process. @returns the run's name
std::string print_into(const std::filesystem::path& runs);

class Served {
 public:
  /// @param change of the options, before the page begins
  explicit Served(const std::function<void(page::ServerOptions&)>& change = {});
  ~Served();
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  std::filesystem::path folder() const { return place.path() / "runs" / id; }

  TempFolder place;
  std::string id, address;
  page::ServerOptions options;

 private:
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

}  // namespace firn::test
