#include "files/mesh/mesh_file.h"

#include <fmt/core.h>
#include <sys/mman.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/mesh/mesh_formats.h"
#include "files/usage_error.h"

namespace firn {
namespace mesh {

void fail_at_byte(const std::string& name, std::size_t byte, const std::string& problem) {
  throw UsageError(fmt::format("{}: byte {}: {}", name, byte, problem));
}

void check_count(const std::string& name, std::size_t byte, std::size_t facets) {
  if (facets > kMaxFacets)
    fail_at_byte(name, byte, fmt::format("{} facets are more than the limit of {}", facets, kMaxFacets));
}

void check_encoding(std::string_view text, const std::string& name) {
  const auto begins = [&](const char* mark) { return text.starts_with(mark); };
  bool little = begins("\xff\xfe"), big = begins("\xfe\xff");
  if (!little && !big && text.size() >= 8) {  // without a mark: every other byte of a Latin text is zero
    little = big = true;
    for (std::size_t n = 0; n < std::min<std::size_t>(text.size(), 64); ++n) {
      if ((text[n] == 0) != (n % 2 == 1)) little = false;
      if ((text[n] == 0) != (n % 2 == 0)) big = false;
    }
  }
  if (little || big) fail_at_byte(name, 0, "is UTF-16 text, where ASCII or UTF-8 is expected");
}

void check_text_form(std::string_view text, const std::string& name) {
  const std::size_t line_end = text.find_first_of("\r\n");
  if (line_end != text.npos && text[line_end] == '\r' && text.find('\n', line_end) == text.npos)
    fail_at_byte(name, line_end, "lines end by carriage returns (CR) alone; convert them to LF or CR LF");
}

Bytes without_byte_order_mark(Bytes bytes) {
  return as_text(bytes).starts_with("\xef\xbb\xbf") ? bytes.subspan(3) : bytes;
}

std::size_t TextCursor::line_of(std::size_t offset) const {
  return first_line_ + std::size_t(std::count(begin_, begin_ + offset, '\n'));
}

void TextCursor::fail(const std::string& problem) const {
  throw UsageError(fmt::format("{}:{}: {}", name_, line_of(std::size_t(word_ - begin_)), problem));
}

double TextCursor::number(std::string_view word, const char* what) const {
  if (const std::optional<double> value = whole_number<double>(word)) return *value;
  // Not finite, or beyond a double: facets that the slicer reports.
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty()) fail(fmt::format("ends where {} is expected", what));
  if (end != word.data() + word.size())
    fail(fmt::format("{} = {}: is not a number{}", what, word.substr(0, 40),
                     word.find(',') == word.npos ? "" : "; its decimal mark must be a point"));
  return error == std::errc() ? value : std::numeric_limits<double>::infinity();
}

std::int64_t TextCursor::whole(std::string_view word, const char* what) const {
  if (const std::optional<std::int64_t> value = whole_number<std::int64_t>(word)) return *value;
  if (word.empty()) fail(fmt::format("ends where {} is expected", what));
  fail(fmt::format("{} = {}: is not a whole number", what, word.substr(0, 40)));
}

}  // namespace mesh

namespace {

record::MappedFile mapped(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw UsageError(file.string() + ": no such file");
  try {
    return record::MappedFile(file);
  } catch (const record::FileError& e) {
    throw UsageError(e.what());
  }
}

}  // namespace

slice::FacetView MeshData::facets() const {
  slice::FacetView view;
  if (!records.empty()) {
    view.soup = records.data() + 12;  // behind the normal
    view.stride = 50;
    view.soup_facets = records.size() / 50;
  } else if (!soup.empty()) {
    view.soup = reinterpret_cast<const std::byte*>(soup.data());
    view.stride = 36;
    view.soup_facets = soup.size() / 9;
  } else {
    view.vertices = vertices;
    view.triangles = triangles;
  }
  view.origin = origin;
  return view;
}

MeshData read_mesh(std::span<const std::byte> bytes, const std::string& name, FacetCount count) {
  const std::string ending = lowercase(std::filesystem::path(name).extension().string());
  MeshData data;
  if (bytes.empty()) throw UsageError(name + ": is empty");
  if (ending == ".stl")
    data = mesh::read_stl(bytes, name, count);
  else if (ending == ".ply")
    data = mesh::read_ply(bytes, name, count);
  else if (ending == ".obj")
    data = mesh::read_obj(bytes, name);
  else if (ending == ".3mf")
    data = mesh::read_3mf(bytes, name);
  else
    throw UsageError(name + ": must end in .stl, .ply, .obj or .3mf");
  if (data.facets().size() == 0) {
    std::string why;
    for (const std::string& defect : data.defects) why += (why.empty() ? ": " : "; ") + defect;
    throw UsageError(name + ": holds no facet" + why);
  }
  return data;
}

MeshFile::MeshFile(const std::filesystem::path& file, FacetCount count)
    : map_(mapped(file)), data_(read_mesh(map_.bytes(), file.string(), count)) {}

slice::FacetView MeshFile::facets() const {
  slice::FacetView view = data_.facets();
  if (data_.records.empty()) return view;
  // Kept between passes: files of 8 million facets are mapped once. Page cache, not memory of our own.
  static constexpr std::size_t kPage = 4096, kHeader = 84, kKept = std::size_t(400) << 20;
  const std::span<const std::byte> all = map_.bytes();
  view.done_with = [all](std::size_t first, std::size_t end, bool follows) {
    const std::size_t kept = follows ? std::min(all.size(), kKept) : 0;  // begin of the next pass
    const std::size_t from = (kHeader + 50 * first + kPage - 1) / kPage * kPage;
    const std::size_t until = std::min(all.size() - kept, kHeader + 50 * end) / kPage * kPage;
    if (from < until) ::madvise(const_cast<std::byte*>(all.data()) + from, until - from, MADV_DONTNEED);
  };
  return view;
}

}  // namespace firn
