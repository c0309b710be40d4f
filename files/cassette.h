// Cassette holds the bytes that crossed the port of one instrument, with their times. `--record` writes it, a
// port "cassette:FILE" plays it, a transcript is made of it. A text file of lines:
//   firn cassette 1 NODE          the first line
//   # text                                 port, SIMULATED or REAL; `# config: ` lines of the experiment
//        12.345 open                       the port opened, or `closed`; times in ms
//        13.001 > 4c 49 0a |LI.|           sent by the host, or `<` received; the text after `|` is for
//        people 13.001 = LAMP_COMMAND 5a |expose| a message to the driver, or `= stop`
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

struct Cassette {
  enum class Kind : std::uint8_t { kOpened, kClosed, kSent, kReceived, kOrder };
  struct Piece {
    Kind kind = Kind::kOpened;
    double ms = 0.0;               ///< since the recording began
    std::vector<std::byte> bytes;  ///< sent or received, or the message of an order
    std::string channel;           ///< of an order; "stop"
    int line = 0;                  ///< of the file
  };

  std::string node;
  std::vector<std::string> remarks;  ///< without "# "
  std::vector<Piece> pieces;
};

/// Returns the first lines of a recording: `remark`, and the experiment, from which the driver is made again.
std::string cassette_head(std::string_view node, std::string_view remark, std::string_view config_toml);
/// Returns the experiment of such a head.
std::string config_of(const Cassette& cassette);
/// Returns one line of it, with its end.
std::string cassette_line(Cassette::Kind kind, double ms, std::span<const std::byte> bytes);
/// Returns ` 4c 49 0a |LI.|`.
std::string shown(std::span<const std::byte> bytes);
std::string cassette_order(std::string_view channel, double ms, std::span<const std::byte> message,
                           std::string_view text);

inline constexpr std::size_t kLongestCassette = std::size_t(256) << 20;

/// @throws std::invalid_argument naming `file`, line and the wanted content: a damaged one, one over 256 MiB
Cassette parse_cassette(std::string_view text, const std::string& file);

}  // namespace firn
