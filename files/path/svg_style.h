// svg::Cascade finds the value of each property of an element: from its attributes, the style sheets of the
// file, and its style attribute [CSS Cascading and Inheritance Level 4, 6].
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/path/svg_document.h"

namespace firn::svg {

struct Value {
  std::string text;     ///< without blanks around it and without !important
  bool is_css = false;  ///< from a style sheet or a style attribute: lengths have units
};

/// The declared properties of an element that decide which shapes are drawn, and where.
class Properties {
 public:
  void set(std::string_view property, Value value) {
    values_.insert_or_assign(std::string(property), std::move(value));
  }
  const Value* find(std::string_view property) const {
    const auto found = values_.find(property);
    return found == values_.end() ? nullptr : &found->second;
  }

 private:
  std::map<std::string, Value, std::less<>> values_;
};

/// A declaration of a style sheet or a style attribute.
struct Declaration {
  std::string property, value;
  bool important = false;
};

/// The step from the element that a compound selector matches to the one on its left.
enum class Combinator { kDescendant, kChild };

/// An element's name, classes and ids that must all match; an empty name matches any.
struct CompoundSelector {
  std::string element;
  std::vector<std::string> classes, ids;
  bool root = false;
  Combinator to_left = Combinator::kDescendant;
};

struct Rule {
  std::vector<CompoundSelector> selector;  ///< from left to right
  std::size_t declarations = 0;            ///< index of a list
};

class Cascade {
 public:
  /// Reads the <style> elements. @throws SyntaxError naming a selector or an at-rule that is not known and
  /// sets a property that decides which shapes are drawn; `line` is then the element's
  Cascade(const Document& document, std::size_t& line);

  /// @throws SyntaxError of a style attribute that is not known
  Properties of(const Element& element) const;

 private:
  void read_sheet(std::string_view text);
  void read_rules(std::string_view text, bool is_nested);
  void add_rule(std::string_view selector, std::string_view block);

  std::vector<std::vector<Declaration>> lists_;
  std::vector<Rule> rules_;                                              ///< in the file's order
  std::map<std::string, std::vector<std::size_t>, std::less<>> by_key_;  ///< rules by an id, class or name
};

}  // namespace firn::svg
