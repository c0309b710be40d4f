// svg::read_document reads the elements of an SVG file with their attributes.
#pragma once

#include <cstddef>
#include <deque>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace firn::svg {

/// Depth of elements, and of elements that <use> inserts into one another.
inline constexpr std::size_t kMaxDepth = 200;

struct Element {
  std::string name;  ///< without the prefix of its namespace
  /// Without those of other namespaces but xlink:href, which is "href".
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string text;  ///< of a style sheet; of another element, only whether it is blank counts
  const Element* parent = nullptr;
  std::vector<const Element*> children;
  std::size_t line = 0, byte = 0;

  std::optional<std::string_view> operator[](std::string_view attribute) const;
};

/// Elements of other namespaces are left out with their content.
struct Document {
  std::deque<Element> elements;  ///< in the file's order; the first one is the outermost svg
  std::map<std::string, const Element*, std::less<>> by_id;
};

/// @throws UsageError naming file and line: of a text that is not XML, of another outermost element, of
/// elements nested deeper than kMaxDepth, and of a style sheet in another file
Document read_document(std::istream& in, const std::string& name);

}  // namespace firn::svg
