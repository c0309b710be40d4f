#include "files/mesh/xml_reader.h"

#include <expat.h>
#include <fmt/core.h>

#include <exception>
#include <utility>

#include "files/usage_error.h"

namespace firn::mesh {
namespace {

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
    of(self).guarded([&] { of(self).handler_.begin(name_of(element), XmlAttributes(attributes)); });
  }
  static void end(void* self, const char* element) {
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
  throw UsageError(fmt::format("{}:{}:{}: {}", source_, XML_GetCurrentLineNumber(parser_.get()),
                               XML_GetCurrentColumnNumber(parser_.get()) + 1, problem));
}

void XmlReader::parse(std::string_view piece, bool last) {
  const XML_Status status = XML_Parse(parser_.get(), piece.data(), int(piece.size()), last);
  if (thrown_) std::rethrow_exception(thrown_);
  if (status != XML_STATUS_OK)
    fail(std::string("is no XML that can be read: ") + XML_ErrorString(XML_GetErrorCode(parser_.get())));
}

void XmlReader::read(std::string_view piece) { parse(piece, false); }
void XmlReader::finish() { parse({}, true); }

}  // namespace firn::mesh
