#include "files/mesh/xml_reader.h"

#include <expat.h>
#include <fmt/core.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "files/usage_error.h"

namespace firn::mesh {
namespace {

constexpr std::size_t kLongestTag = 4096;  // held from one piece to the next
constexpr char kBetween = '|';  // stands between a namespace's address and a name; no address has it

XmlName name_of(std::string_view text) {
  const std::size_t at = text.rfind(kBetween);
  return at == text.npos ? XmlName{{}, text} : XmlName{text.substr(0, at), text.substr(at + 1)};
}

}  // namespace

std::optional<std::string_view> XmlAttributes::find(std::string_view space, std::string_view local) const {
  for (const char** pair = pairs_; *pair; pair += 2) {
    const XmlName name = name_of(pair[0]);
    if (name.space == space && name.local == local) return pair[1];
  }
  return std::nullopt;
}

void XmlReader::Free::operator()(XML_ParserStruct* parser) const { XML_ParserFree(parser); }

template <class Call>
void XmlReader::guarded(const Call& call) {
  if (thrown_) return;
  try {
    call();
  } catch (...) {
    thrown_ = std::current_exception();
    XML_StopParser(parser_.get(), XML_FALSE);
  }
}

struct XmlReader::Callbacks {
  static XmlReader& of(void* self) { return *static_cast<XmlReader*>(self); }
  static void begin(void* self, const char* element, const char** attributes) {
    ++of(self).begun_;
    of(self).guarded([&] { of(self).handler_.begin(name_of(element), XmlAttributes(attributes)); });
  }
  static void end(void* self, const char* element) {
    ++of(self).ended_;
    of(self).guarded([&] { of(self).handler_.end(name_of(element)); });
  }
  static void text(void* self, const char* text, int bytes) {
    of(self).guarded([&] { of(self).handler_.text({text, std::size_t(bytes)}); });
  }
  static void space(void* self, const char* prefix, const char* address) {
    of(self).spaces_[prefix ? prefix : ""] = address ? address : "";
  }
  static void document_type(void* self, const char*, const char*, const char*, int) {
    of(self).guarded([&] { of(self).fail("has a document type, which is not read"); });
  }
};

XmlReader::XmlReader(std::string source, XmlHandler& handler)
    : source_(std::move(source)), handler_(handler), parser_(XML_ParserCreateNS(nullptr, kBetween)) {
  XML_SetUserData(parser_.get(), this);
  XML_SetElementHandler(parser_.get(), &Callbacks::begin, &Callbacks::end);
  XML_SetCharacterDataHandler(parser_.get(), &Callbacks::text);
  XML_SetStartNamespaceDeclHandler(parser_.get(), &Callbacks::space);
  XML_SetStartDoctypeDeclHandler(parser_.get(), &Callbacks::document_type);
}

XmlReader::~XmlReader() = default;

std::string XmlReader::space_of(const std::string& prefix) const {
  const auto at = spaces_.find(prefix);
  return at == spaces_.end() ? std::string() : at->second;
}

void XmlReader::fail(const std::string& problem) const {
  const std::uint64_t line = XML_GetCurrentLineNumber(parser_.get());
  const std::int64_t column = std::int64_t(XML_GetCurrentColumnNumber(parser_.get())) + 1;
  throw UsageError(fmt::format("{}:{}:{}: {}", source_, line + skipped_lines_,
                               column + (line == shifted_line_ ? shift_ : 0), problem));
}

void XmlReader::parse(std::string_view piece, bool last) {
  parsed_ += piece.size();
  const XML_Status status = XML_Parse(parser_.get(), piece.data(), int(piece.size()), last);
  if (thrown_) std::rethrow_exception(thrown_);
  if (status != XML_STATUS_OK)
    fail(std::string("is no XML that can be read: ") + XML_ErrorString(XML_GetErrorCode(parser_.get())));
}

bool XmlReader::all_parsed() const {
  return std::uint64_t(XML_GetCurrentByteIndex(parser_.get())) == parsed_;
}

// A tag that expat reports ends with the piece's only ">", unless expat still held something before it.
// Elements without a prefix have the namespace of the element around them only if that one has no prefix
// either.
void XmlReader::parse_to_tag(std::string_view piece) {
  const bool clean = parsed_ == 0 || all_parsed();
  const std::uint64_t begun = begun_, ended = ended_;
  parse(piece, false);
  if (begun_ == begun && ended_ == ended) return void(at_rows_ = false);  // text, a comment
  const std::size_t name = piece.rfind('<') + 1;
  const bool has_prefix =
      piece.substr(name, piece.find_first_of(" \t\r\n/>", name) - name).find(':') != piece.npos;
  const bool opens = begun_ > begun && ended_ == ended;
  const bool is_empty = begun_ > begun && ended_ > ended;
  in_rows_ = clean && all_parsed() && (opens ? !has_prefix : is_empty && in_rows_) && handler_.expects_rows();
  at_rows_ = in_rows_;
}

void XmlReader::skip(std::string_view rows) {
  const std::uint64_t line = XML_GetCurrentLineNumber(parser_.get());
  const std::size_t last = rows.rfind('\n');
  if (last == rows.npos) {
    shift_ = (line == shifted_line_ ? shift_ : 0) + std::int64_t(rows.size());
  } else {
    skipped_lines_ += std::uint64_t(std::ranges::count(rows, '\n'));
    shift_ = std::int64_t(rows.size() - last - 1) - std::int64_t(XML_GetCurrentColumnNumber(parser_.get()));
  }
  shifted_line_ = line;
}

void XmlReader::read(std::string_view piece) {
  const std::string joined = held_.empty() ? std::string() : std::exchange(held_, {}).append(piece);
  std::string_view text = joined.empty() ? piece : joined;
  while (!text.empty()) {
    if (at_rows_) {
      const std::size_t rows = handler_.read_rows(text);
      skip(text.substr(0, rows));
      text.remove_prefix(rows);
    }
    const std::size_t end = text.find('>');
    const std::size_t tag = end == text.npos ? text.rfind('<') : text.npos;
    if (tag != text.npos && text.size() - tag < kLongestTag) {  // the next piece has its end
      held_ = text.substr(tag);
      text = text.substr(0, tag);
      if (!text.empty()) parse_to_tag(text);
      return;
    }
    const std::string_view to_tag = text.substr(0, end == text.npos ? end : end + 1);
    parse_to_tag(to_tag);
    text.remove_prefix(to_tag.size());
  }
}

void XmlReader::finish() {
  parse(std::exchange(held_, {}), false);
  parse({}, true);
}

}  // namespace firn::mesh
