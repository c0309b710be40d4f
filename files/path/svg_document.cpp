#include "files/path/svg_document.h"

#include <expat.h>
#include <fmt/core.h>

#include <exception>
#include <istream>
#include <memory>

#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn::svg {
namespace {

constexpr std::string_view kSvgNamespace = "http://www.w3.org/2000/svg";

std::pair<std::string_view, std::string_view> split_name(std::string_view name) {
  const std::size_t colon = name.find(':');
  if (colon == name.npos) return {"", name};
  return {name.substr(0, colon), name.substr(colon + 1)};
}

class SvgDocumentReader {
 public:
  SvgDocumentReader(std::istream& in, const std::string& name)
      : in_(in), name_(name), parser_(XML_ParserCreate(nullptr)) {
    if (!parser_) throw std::bad_alloc();
    using Reader = SvgDocumentReader;
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const char* element, const char** attributes) {
          static_cast<Reader*>(self)->guarded([&](Reader& reader) { reader.start(element, attributes); });
        },
        [](void* self, const char*) {
          static_cast<Reader*>(self)->guarded([](Reader& reader) { reader.end(); });
        });
    XML_SetCharacterDataHandler(parser_.get(), [](void* self, const char* text, int size) {
      static_cast<Reader*>(self)->guarded([&](Reader& reader) {
        reader.characters({text, std::size_t(size)});
      });
    });
    XML_SetProcessingInstructionHandler(parser_.get(), [](void* self, const char* target, const char*) {
      static_cast<Reader*>(self)->guarded([&](Reader& reader) {
        if (std::string_view(target) == "xml-stylesheet")
          reader.fail("a style sheet in another file is not read: put it into a <style>");
      });
    });
  }

  Document read() {
    constexpr std::size_t kBlock = 1 << 16;
    std::vector<char> block(kBlock);
    for (bool last = false; !last;) {
      in_.read(block.data(), std::streamsize(kBlock));
      last = !in_;
      const auto status = XML_Parse(parser_.get(), block.data(), int(in_.gcount()), last);
      if (error_) std::rethrow_exception(error_);
      if (status != XML_STATUS_OK)
        fail(fmt::format("is not XML: {}", XML_ErrorString(XML_GetErrorCode(parser_.get()))));
    }
    return std::move(document_);
  }

 private:
  struct Free {
    void operator()(XML_Parser p) const { XML_ParserFree(p); }
  };

  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, line(), problem));
  }

  std::size_t line() const { return std::size_t(XML_GetCurrentLineNumber(parser_.get())); }

  /// Exceptions do not pass through the parser, which is C.
  template <class Action>
  void guarded(Action&& action) {
    if (error_) return;
    try {
      action(*this);
    } catch (...) {
      error_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  void start(std::string_view tag, const char** attributes) {
    if (open_.size() + foreign_ == kMaxDepth) fail(fmt::format("elements nested deeper than {}", kMaxDepth));
    const std::size_t scopes = namespaces_.size();
    for (const char** a = attributes; a[0]; a += 2) {
      const auto [prefix, local] = split_name(a[0]);
      if (prefix == "xmlns") namespaces_.emplace_back(local, a[1]);
      if (prefix.empty() && local == "xmlns") namespaces_.emplace_back("", a[1]);
    }
    scopes_.push_back(scopes);
    const auto [prefix, local] = split_name(tag);
    if (foreign_ > 0 || !in_svg(prefix)) {
      if (open_.empty()) fail("the first element must be svg");
      ++foreign_;
      return;
    }
    if (open_.empty() && local != "svg") fail("the first element must be svg");
    Element& element = document_.elements.emplace_back();
    element.name = std::string(local);
    element.line = line();
    element.byte = std::size_t(XML_GetCurrentByteIndex(parser_.get()));
    for (const char** a = attributes; a[0]; a += 2) add_attribute(element, a[0], a[1]);
    if (!open_.empty()) {
      element.parent = open_.back();
      open_.back()->children.push_back(&element);
    }
    if (const auto id = element["id"]) document_.by_id.emplace(std::string(*id), &element);
    open_.push_back(&element);
  }

  void end() {
    namespaces_.resize(scopes_.back());
    scopes_.pop_back();
    if (foreign_ > 0)
      --foreign_;
    else
      open_.pop_back();
  }

  void characters(std::string_view text) {
    if (foreign_ > 0 || open_.empty()) return;
    Element& element = *open_.back();
    if (element.name == "style" || (element.text.empty() && !trimmed(text).empty())) element.text += text;
  }

  static void add_attribute(Element& element, std::string_view name, const char* value) {
    const auto [prefix, local] = split_name(name);
    if (prefix.empty()) element.attributes.emplace_back(local, value);
    if (prefix == "xlink" && local == "href") element.attributes.emplace_back("href", value);
  }

  /// The innermost declaration of a prefix counts. Files without any are SVG, too.
  bool in_svg(std::string_view prefix) const {
    for (std::size_t i = namespaces_.size(); i-- > 0;)
      if (namespaces_[i].first == prefix) return namespaces_[i].second == kSvgNamespace;
    return prefix.empty() || prefix == "svg";
  }

  std::istream& in_;
  const std::string& name_;
  std::unique_ptr<XML_ParserStruct, Free> parser_;
  std::exception_ptr error_;
  Document document_;
  std::vector<Element*> open_;
  std::size_t foreign_ = 0;  ///< open elements of other namespaces and within them
  std::vector<std::pair<std::string, std::string>> namespaces_;  ///< prefix and name, innermost last
  std::vector<std::size_t> scopes_;  ///< number of namespaces outside of each open element
};

}  // namespace

std::optional<std::string_view> Element::operator[](std::string_view attribute) const {
  for (const auto& [name, value] : attributes)
    if (name == attribute) return value;
  return std::nullopt;
}

Document read_document(std::istream& in, const std::string& name) {
  return SvgDocumentReader(in, name).read();
}

}  // namespace firn::svg
