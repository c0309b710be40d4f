// Any text as a cassette: one that is written back the same and plays, or one std::invalid_argument.
#include <stdexcept>
#include <string>

#include "runtime/cassette_deck.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Cassette c;
  try {
    c = parse_cassette({reinterpret_cast<const char*>(data), size}, "fuzz.cassette");
  } catch (const std::invalid_argument&) {
    return 0;
  }
  std::string text = cassette_head(c.node, "fuzz", config_of(c));
  for (const Cassette::Piece& p : c.pieces)
    text += p.kind == Cassette::Kind::kOrder ? cassette_order(p.channel, p.ms, p.bytes, "")
                                             : cassette_line(p.kind, p.ms, p.bytes);
  const Cassette again = parse_cassette(text, "again.cassette");
  require(again.node == c.node && config_of(again) == config_of(c), "node and experiment");
  require(again.pieces.size() == c.pieces.size(), "every piece");
  for (std::size_t n = 0; n < c.pieces.size(); ++n)
    require(again.pieces[n].kind == c.pieces[n].kind && again.pieces[n].bytes == c.pieces[n].bytes &&
                again.pieces[n].channel == c.pieces[n].channel,
            "the same piece");
  CassetteDeck deck(c);
  std::int64_t now_us = 1;
  deck.open(now_us);
  std::size_t taken = 0;
  for (const Cassette::Piece& p : c.pieces) {
    if (p.kind == Cassette::Kind::kSent) require(deck.send(p.bytes, now_us), "what is on the tape is found");
    bool closed = false;
    std::vector<std::byte> bytes;
    while (deck.due_us() != INT64_MAX) {
      now_us = std::max(now_us, deck.due_us());
      require(deck.take(now_us, bytes, closed), "what is due is taken");
      require(++taken <= c.pieces.size() * (c.pieces.size() + 2), "an end");
    }
  }
  return 0;
}
