// The first words that two hosts of a run exchange: which builds they are, which processes run there, and
// which files these need.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "procs/relay/file_stream.h"

namespace firn::relay {

/// Address of a host for ssh, and the program there.
struct HostPlace {
  std::string address, program;
};
/// Reads "USER@HOST" or "USER@HOST:/path/to/firn", as [hosts] has it.
HostPlace place_of(const std::string& text);

/// Raised whenever a frame, a hello or a line means something else.
inline constexpr int kProtocol = 2;

/// The launcher's order to a host.
struct HostOrder {
  std::string name;     ///< of the host in [hosts]
  std::string address;  ///< of ssh
  std::string program;  ///< of firn there
  std::int64_t run_id = 0;
  std::string run;                     ///< name of the run folder
  std::string place;                   ///< of the run folder at the launcher, absolute
  std::vector<std::string> nodes;      ///< that run there
  std::vector<std::string> arguments;  ///< of their processes, as the launcher's have them (process_args.h)
  std::map<std::string, FileState> files;  ///< that they need, at the launcher: path in the run folder
  double slack_ms = 0.0;                   ///< most by which the host's clock may be unknown
  double silence_s = 0.0;                  ///< without a word: the host is lost
  std::vector<std::string> simulated;      ///< ports there whose instruments are in the simulated world
  bool collect = false;                    ///< start nothing; send the records
};

/// The two sides' descriptions of themselves.
struct HostFacts {
  int protocol = kProtocol;
  std::string version, commit, sources;  ///< runtime/build_info.h
  std::string platform;                  ///< runtime/build_info.h
  std::string results;                   ///< digest of the fingerprint of results
  std::string boot_id;                   ///< of the running kernel: equal where files and clock are shared
  std::string host;                      ///< its own name
};
HostFacts own_facts();
/// Returns why two hosts cannot run one print; empty: they can.
std::string unlike(const HostFacts& launcher, const HostFacts& host);

struct Hello {
  HostFacts facts;
  HostOrder order;                 ///< the launcher's
  std::vector<std::string> wants;  ///< the host's: files to send
  std::string lane;                ///< the host's: its socket for further lanes
};

/// One line of JSON, and back. @throws std::invalid_argument naming the member that is missing or of another
/// kind
std::string to_json(const HostOrder& order);
HostOrder order_from_json(const std::string& text);
std::string to_json(const Hello& hello);
Hello hello_from_json(const std::string& text);
std::string to_json(const std::map<std::string, FileState>& files);
std::map<std::string, FileState> files_from_json(const std::string& text);

/// Files in the run folder that a process of a run appends to: "nodes/jet.wal", "nodes/jet.err",
/// "cassettes/jet.cassette"; and the one that it writes anew.
std::vector<std::string> grown_by(const std::string& node);
std::string faults_of(const std::string& node);
/// Returns true for the name of a file that one of `nodes` makes.
bool is_made_by(const std::vector<std::string>& nodes, std::string_view name);

}  // namespace firn::relay
