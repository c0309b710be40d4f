// Any text: a browser's frame or notes are read or refused.
#include <stdexcept>
#include <string_view>

#include "page/client_frame.h"
#include "page/web_rules.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const firn::page::ClientFrame f = firn::page::parse_client_frame(text);
    for (const std::string& word : f.words)
      firn::fuzz::require(word.find('\n') == std::string::npos, "an order is one line");
  } catch (const std::invalid_argument&) {
  }
  try {
    const firn::page::Notes notes = firn::page::parse_notes(text, nullptr);
    const firn::page::Notes back = firn::page::parse_notes(firn::page::to_json(notes), nullptr);
    firn::fuzz::require(back.tags == notes.tags && back.note == notes.note, "notes come back");
  } catch (const std::invalid_argument&) {
  }
  for (const std::string& part : firn::page::path_parts(text))
    firn::fuzz::require(part != ".." && part.find('/') == std::string::npos, "a part stays in its folder");
  for (const std::string& value : firn::page::query_values(text, "run"))
    firn::fuzz::require(value != ".." && value.find('/') == std::string::npos, "a value stays in its folder");
  for (const std::string_view word : firn::page::list_words(text))
    firn::fuzz::require(!word.empty() && word.find(',') == word.npos, "a word of a list has no comma");
  return 0;
}
