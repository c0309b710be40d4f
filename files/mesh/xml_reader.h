// XmlReader passes the elements of an XML text to a handler, by expat: names with their namespace, a place
// for errors. Document types, and with them entities, are refused.
#pragma once

#include <cstdint>
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

/// A handler may read rows itself: hundreds of thousands of empty elements, one behind the other, in an
/// element that it expects them in. The rest goes through expat, which checks it.
class XmlHandler {
 public:
  virtual ~XmlHandler() = default;
  /// Returns true if rows may follow here, in the element that has begun last and not ended.
  virtual bool expects_rows() const { return false; }
  /// Reads white space and elements, whole and without a prefix, from the start of `text` on, which stands
  /// between two elements. @returns the number of bytes read; what follows is something else, or cut
  virtual std::size_t read_rows(std::string_view) { return 0; }
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
  /// @param piece that ends with its first ">", or has none
  void parse_to_tag(std::string_view piece);
  bool all_parsed() const;
  void skip(std::string_view rows);
  template <class Call>
  void guarded(const Call& call);

  std::string source_;
  XmlHandler& handler_;
  struct Free {
    void operator()(XML_ParserStruct* parser) const;
  };
  std::unique_ptr<XML_ParserStruct, Free> parser_;
  std::map<std::string, std::string> spaces_;
  std::exception_ptr thrown_;            ///< by the handler: it must not pass through expat
  std::uint64_t parsed_ = 0;             ///< bytes given to expat
  std::uint64_t begun_ = 0, ended_ = 0;  ///< elements
  bool in_rows_ = false;                 ///< the open element may have rows
  bool at_rows_ = false;                 ///< and the bytes that come stand between two of its elements
  std::string held_;                     ///< a tag that the last piece cut
  // Places in the text beside those that expat knows of:
  std::uint64_t skipped_lines_ = 0;
  std::uint64_t shifted_line_ = 0;  ///< of expat
  std::int64_t shift_ = 0;          ///< of its columns
};

}  // namespace firn::mesh
