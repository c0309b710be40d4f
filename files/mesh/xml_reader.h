// XmlReader passes the elements of an XML text to a handler, by expat: names with their namespace, a place
// for errors. Document types, and with them entities, are refused.
#pragma once

#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct XML_ParserStruct;

namespace firn::mesh {

/// An element's or an attribute's name. `space` is the address of its namespace; empty = none.
struct XmlName {
  std::string_view space, local;
};

/// The attributes of one element, valid within the call.
class XmlAttributes {
 public:
  explicit XmlAttributes(const char** pairs) : pairs_(pairs) {}
  /// The value of an attribute without a namespace; nothing: the element has none.
  std::optional<std::string_view> find(std::string_view local) const { return find("", local); }
  std::optional<std::string_view> find(std::string_view space, std::string_view local) const;

 private:
  const char** pairs_;
};

class XmlHandler {
 public:
  virtual ~XmlHandler() = default;
  virtual void begin(const XmlName& element, const XmlAttributes& attributes) = 0;
  virtual void end(const XmlName&) {}
  virtual void text(std::string_view) {}
};

class XmlReader {
 public:
  /// @param source named in errors: "part.3mf: 3D/3dmodel.model"
  XmlReader(std::string source, XmlHandler& handler);
  ~XmlReader();
  /// Reads the next piece of the text. @throws UsageError with line and column: not well-formed, a document
  /// type; the errors of the handler
  void read(std::string_view piece);
  void finish();

  /// The namespace that a prefix has been declared for; empty: none.
  std::string space_of(const std::string& prefix) const;
  /// @throws UsageError at the place of the element that is being read
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  struct Callbacks;
  void parse(std::string_view piece, bool last);
  template <class Call>
  void guarded(const Call& call);

  std::string source_;
  XmlHandler& handler_;
  struct Free {
    void operator()(XML_ParserStruct* parser) const;
  };
  std::unique_ptr<XML_ParserStruct, Free> parser_;
  std::map<std::string, std::string> spaces_;
  std::exception_ptr thrown_;  ///< by the handler: it must not pass through expat
};

}  // namespace firn::mesh
