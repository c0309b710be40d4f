// Serves the page over HTTP and WebSocket: the files of the page, lists of runs, live rows and maps,
// commands.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace firn {
struct Product;
}

namespace firn::page {

struct ServerOptions {
  std::vector<std::filesystem::path> places;  ///< run folders, and folders of run folders
  std::filesystem::path live;      ///< folder of the print that this process belongs to; empty: none
  std::string bind = "127.0.0.1";  ///< address to listen on; beyond loopback a proxy with TLS is wanted
  int port = 0;                    ///< 0: the first free one from kFirstPort on
  std::vector<std::string> hosts;  ///< further names of this page, "lab.example.org[:PORT]"
  std::string token;               ///< commands and reading ask for it; empty: there are no commands
  std::filesystem::path
      index;  ///< of the runs (runs/find/run_index.h); empty: in memory; of a live print the user's
  bool is_public = false;        ///< whoever reaches the page may read
  std::filesystem::path people;  ///< table of those who have tokens of their own (page/access.h); empty: none
  std::filesystem::path firn;    ///< program that resumes a run; empty: the one beside this process's own
  int stop_fd = -1;              ///< the server ends when it is readable; -1: never
  std::function<void(const std::string& address)> listening;  ///< "http://127.0.0.1:8750/"
};

inline constexpr int kFirstPort = 8750;
inline constexpr int kMaxConnections = 200;  ///< further ones are closed at once

/// @param product whose labs the runs may be of
/// Serves until stop_fd is readable. The calling thread and those that read give way to all other work (nice
/// 10) where a print runs: from the beginning with `live`, else once one is opened. Commands keep the
/// caller's priority.
/// @throws UsageError: an address that is none or not this machine's, a port in use, a place that is no
/// folder
void serve(const Product& product, const ServerOptions& options);

}  // namespace firn::page
