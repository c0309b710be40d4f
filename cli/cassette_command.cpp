// run_cassette shows the record of an instrument's port, and holds it against the driver of today.
#include "cli/commands.h"

#include <fmt/core.h>

#include <cstdio>
#include <string>

#include "cli/option_set.h"
#include "files/cassette.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/device/cassette_replay.h"

namespace firn {
namespace {

struct CassetteOptions {
  std::string file;
  std::string keep;  ///< file of a transcript test that is written
  bool json = false;
};

/// @returns 0, or 1 where the driver of today sends something else than the tape has
int run_cassette(const Product& product, const CassetteOptions& o) try {
  const std::string text = read_file(o.file);
  const Cassette c = parse_cassette(text, o.file);
  int sent = 0, received = 0, orders = 0;
  for (const Cassette::Piece& p : c.pieces) {
    sent += p.kind == Cassette::Kind::kSent;
    received += p.kind == Cassette::Kind::kReceived;
    orders += p.kind == Cassette::Kind::kOrder;
  }
  const double seconds = c.pieces.empty() ? 0.0 : (c.pieces.back().ms - c.pieces.front().ms) * 1e-3;
  const std::string from = c.remarks.empty() ? "" : c.remarks.front();
  const std::string difference = replay_cassette(product, c);
  if (!o.keep.empty()) write_file_atomically(o.keep, text);
  if (o.json)
    std::puts(nlohmann::ordered_json{{"node", c.node},
                                     {"from", from},
                                     {"seconds", seconds},
                                     {"sent", sent},
                                     {"received", received},
                                     {"orders", orders},
                                     {"difference", difference}}
                  .dump(2)
                  .c_str());
  else
    fmt::print("{} ({}): {:.1f} s, {} pieces sent, {} received, {} orders\n{}\n", c.node, from, seconds, sent,
               received, orders,
               difference.empty() ? "the driver of today sends the same" : "DIFFERENT: " + difference);
  return difference.empty() ? kOk : kFailed;
} catch (const std::invalid_argument& e) {
  throw UsageError(e.what());
}

}  // namespace

void declare_cassette(OptionSet& options) {
  auto& o = options.calls(&run_cassette);
  options.option("FILE", o.file, "what --record of firn device or firn print has written").required();
  options.option("--keep", o.keep, "write it as a test: a file in tests/drivers/cassettes");
  options.json_flag(o.json);
}

}  // namespace firn
