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
    const firn::page::NoteRequest asked = firn::page::parse_note_request(text);
    firn::fuzz::require(asked.note.size() <= firn::page::kMaxNotesBytes, "a note has its limit");
    for (const std::string& tag : asked.add_tags)
      firn::fuzz::require(tag.size() <= firn::page::kMaxTagBytesOfRequest, "a tag has its limit");
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
