// STL: 80 bytes, a u32 count and records of 50 bytes; or text that begins with "solid".
#include <fmt/core.h>

#include <algorithm>

#include "files/mesh/mesh_builder.h"
#include "files/mesh/mesh_formats.h"

namespace firn::mesh {
namespace {

constexpr std::size_t kHeader = 84, kRecord = 50;

// Letters of keywords in any case.
bool is(std::string_view word, std::string_view keyword) {
  return word.size() == keyword.size() && std::equal(word.begin(), word.end(), keyword.begin(),
                                                     [](char a, char b) { return (a | 0x20) == b; });
}

// A text has words where a binary file has control characters. Some texts begin with remarks, and some binary
// files with "solid".
bool looks_like_text(std::string_view text) {
  const std::string_view front = text.substr(0, 4096);
  if (std::any_of(front.begin(), front.end(), [](char c) { return static_cast<unsigned char>(c) < 9; }))
    return false;
  static constexpr std::string_view kBlanks = " \t\r\n";
  for (std::size_t at = 0; (at = front.find_first_not_of(kBlanks, at)) != front.npos;) {
    const std::size_t end = std::min(front.find_first_of(kBlanks, at), front.size());
    for (const std::string_view keyword : {"solid", "facet", "vertex", "endsolid"})
      if (is(front.substr(at, end - at), keyword)) return true;
    at = end;
  }
  return false;
}

// Behind "endsolid": the beginning of a solid or a facet, and no sentence with such a word?
bool begins_element(std::string_view word, std::string_view rest) {
  if (is(word, "solid") || is(word, "endsolid")) return true;
  const std::size_t next = rest.find_first_not_of(" \t\r\n");
  return is(word, "facet") && next != rest.npos && is(rest.substr(next, 6), "normal");
}

// Text on the same line behind "endloop" or "endfacet"; the next element may stand there too.
bool skip_remark(TextCursor& at) {
  TextCursor ahead = at;
  const std::string_view word = ahead.word_in_line();
  for (const std::string_view keyword : {"", "endfacet", "facet", "endsolid", "solid"})
    if (is(word, keyword)) return false;
  at.skip_line();
  return true;
}

MeshData read_text(std::string_view text, const std::string& name) {
  MeshData data;
  data.format = "ASCII STL";
  data.soup.reserve(text.size() / 25 + 9);  // nine numbers take some 250 bytes with their words
  check_text_form(text, name);
  TextCursor at(text, name);
  NearOrigin near;
  bool in_solid = false, in_facet = false, after_solid = false;
  std::size_t corners = 0, remarks = 0;
  for (std::string_view word = at.word(); !word.empty(); word = at.word()) {
    if (after_solid && !begins_element(word, at.rest())) {  // remarks of the writing program, as signatures
      ++remarks;
      at.skip_line();
    } else if (is(word, "vertex")) {
      if (!in_facet) at.fail("a vertex outside a facet");
      if (++corners > 3) at.fail("a facet with more than 3 vertices");
      std::array<double, 3> p;
      for (double& c : p) c = at.number(at.word(), "a coordinate");
      const slice::Corner corner = near(p);
      data.soup.insert(data.soup.end(), corner.begin(), corner.end());
    } else if (is(word, "facet")) {
      if (in_facet) at.fail("a facet within a facet");
      in_facet = true;
      after_solid = false;
      corners = 0;
      if (!is(at.word(), "normal")) at.fail("\"facet\" without \"normal\"");
      for (int axis = 0; axis < 3; ++axis)
        if (at.word().empty()) at.fail("ends within a normal");
    } else if (is(word, "outer")) {
      if (!is(at.word(), "loop")) at.fail("\"outer\" without \"loop\"");
    } else if (is(word, "endloop")) {
      if (corners != 3) at.fail(fmt::format("a facet with {} vertices instead of 3", corners));
      remarks += skip_remark(at);
    } else if (is(word, "endfacet")) {
      if (!in_facet || corners != 3)
        at.fail(fmt::format("a facet with {} vertices instead of 3", in_facet ? corners : 0));
      in_facet = false;
      remarks += skip_remark(at);
    } else if (is(word, "solid") || is(word, "endsolid")) {
      if (in_facet) at.fail("ends within a facet");
      in_solid = is(word, "solid");
      after_solid = !in_solid;
      at.skip_line();
    } else {
      at.fail(fmt::format("unknown word \"{}\"", word.substr(0, 40)));
    }
  }
  if (in_facet) at.fail("the file ends within a facet");
  if (in_solid) data.defects.push_back("the file ends without endsolid");
  if (remarks > 0) data.defects.push_back(fmt::format("{} lines have text behind an end tag", remarks));
  check_count(name, 0, data.soup.size() / 9);
  data.origin = near.at();
  return data;
}

}  // namespace

MeshData read_stl(Bytes bytes, const std::string& name, FacetCount choice) {
  bytes = without_byte_order_mark(bytes);
  std::uint32_t claimed = 0;
  if (bytes.size() >= kHeader) std::memcpy(&claimed, bytes.data() + 80, sizeof claimed);
  const std::size_t wanted = kHeader + kRecord * std::size_t(claimed);
  if (bytes.size() != wanted || bytes.size() < kHeader) {
    check_encoding(as_text(bytes), name);
    if (looks_like_text(as_text(bytes))) return read_text(as_text(bytes), name);
    if (bytes.size() < kHeader) fail_at_byte(name, bytes.size(), "ends within the header of 84 bytes");
  }
  const std::size_t held = (bytes.size() - kHeader) / kRecord;
  const bool lacks = bytes.size()<wanted, has_more = held> claimed;
  if ((lacks || has_more) && (choice == FacetCount::kAgree || (choice == FacetCount::kHeader && lacks)))
    fail_at_byte(
        name, 80,
        fmt::format("the header claims {} facets, which take {} bytes; the file has {} bytes, enough "
                    "for {}: {}",
                    claimed, wanted, bytes.size(), held, kChooseCount));
  const std::size_t count = choice == FacetCount::kFile ? held : claimed;
  check_count(name, 80, count);
  MeshData data;
  data.format = "binary STL";
  const std::size_t used = kHeader + kRecord * count;
  data.records = bytes.subspan(kHeader, used - kHeader);
  if (count != claimed)
    data.defects.push_back(
        fmt::format("the header claims {} facets; the {} that the file holds are read", claimed, count));
  if (bytes.size() > used)
    data.defects.push_back(fmt::format("{} bytes stand behind the last facet", bytes.size() - used));
  return data;
}

}  // namespace firn::mesh
