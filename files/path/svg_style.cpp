#include "files/path/svg_style.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <tuple>

#include "files/lowercase.h"
#include "files/path/svg_shapes.h"
#include "files/trimmed.h"

namespace firn::svg {
namespace {

struct Property {
  std::string_view name;
  bool is_attribute;  ///< an attribute of the same name sets it, too
};

/// Properties that decide which shapes are drawn, and where. Others are passed over.
constexpr std::array<Property, 37> kProperties{{{"display", true},
                                                {"visibility", true},
                                                {"opacity", true},
                                                {"color", true},
                                                {"fill", true},
                                                {"fill-opacity", true},
                                                {"stroke", true},
                                                {"stroke-opacity", true},
                                                {"stroke-width", true},
                                                {"transform", true},
                                                {"transform-origin", true},
                                                {"transform-box", true},
                                                {"translate", false},
                                                {"rotate", false},
                                                {"scale", false},
                                                {"offset", false},
                                                {"offset-path", false},
                                                {"all", false},
                                                {"d", false},
                                                {"clip-path", true},
                                                {"mask", true},
                                                {"mask-image", false},
                                                {"filter", true},
                                                {"marker", false},
                                                {"marker-start", true},
                                                {"marker-mid", true},
                                                {"marker-end", true},
                                                {"overflow", true},
                                                {"x", true},
                                                {"y", true},
                                                {"width", true},
                                                {"height", true},
                                                {"cx", true},
                                                {"cy", true},
                                                {"rx", true},
                                                {"r", true},
                                                {"ry", true}}};

const Property* property_named(std::string_view name) {
  const auto* const found =
      std::find_if(kProperties.begin(), kProperties.end(), [&](const Property& p) { return p.name == name; });
  return found == kProperties.end() ? nullptr : found;
}

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  std::string shown(trimmed(text).substr(0, 60));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');
  throw SyntaxError(fmt::format("style: \"{}\" {}", shown, why));
}

/// The text with a blank for each comment and without the signs that hid style sheets from old browsers.
std::string without_comments(std::string_view text) {
  std::string out;
  char quote = '\0';
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quote != '\0') {
      if (text[i] == quote) quote = '\0';
    } else if (text.substr(i).starts_with("/*")) {
      const std::size_t end = text.find("*/", i + 2);
      if (end == text.npos) return out;
      i = end + 1;
      out += ' ';
      continue;
    } else if (text.substr(i).starts_with("<!--")) {
      i += 3;
      continue;
    } else if (text.substr(i).starts_with("-->")) {
      i += 2;
      continue;
    } else if (text[i] == '"' || text[i] == '\'') {
      quote = text[i];
    }
    out += text[i];
  }
  return out;
}

/// The position of the first of `signs` outside of quotes and brackets, from `from` on; the size if there is
/// none.
std::size_t find_outside(std::string_view text, std::string_view signs, std::size_t from = 0) {
  char quote = '\0';
  int depth = 0;
  for (std::size_t i = from; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\') {
      ++i;
    } else if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (depth == 0 && signs.find(c) != signs.npos) {
      return i;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '(' || c == '[' || c == '{') {
      ++depth;
    } else if (c == ')' || c == ']' || c == '}') {
      depth = std::max(0, depth - 1);
    }
  }
  return text.size();
}

/// Splits at a sign outside of quotes and brackets.
template <class Take>
void split(std::string_view text, char sign, Take&& take) {
  const char signs[] = {sign, '\0'};
  while (true) {
    const std::size_t end = find_outside(text, signs);
    take(text.substr(0, end));
    if (end == text.size()) return;
    text.remove_prefix(end + 1);
  }
}

/// The declarations that decide which shapes are drawn.
std::vector<Declaration> declarations(std::string_view block) {
  std::vector<Declaration> out;
  split(block, ';', [&](std::string_view one) {
    if (find_outside(one, "{") != one.size()) refuse(one, "is a rule within a rule, which is not read");
    const std::size_t colon = one.find(':');
    if (colon == one.npos) return;
    const std::string name = lowercase(trimmed(one.substr(0, colon)));
    if (property_named(name) == nullptr) return;
    std::string_view value = trimmed(one.substr(colon + 1));
    const std::size_t mark = find_outside(value, "!");
    const bool important = lowercase(trimmed(value.substr(std::min(value.size(), mark + 1)))) == "important";
    value = trimmed(value.substr(0, mark));
    if (value.empty()) return;
    if (lowercase(value).find("var(") != std::string::npos) refuse(one, "holds var(), which is not read");
    out.push_back({name, std::string(value), important});
  });
  return out;
}

/// Says whether rules that are not read would decide which shapes are drawn.
bool sets_property(std::string_view rules) {
  while (!rules.empty()) {
    const std::size_t end = std::min(rules.size(), rules.find_first_of("{};"));
    const std::string_view one = rules.substr(0, end);
    if (property_named(lowercase(trimmed(one.substr(0, one.find(':'))))) != nullptr) return true;
    rules.remove_prefix(std::min(rules.size(), end + 1));
  }
  return false;
}

bool is_name_sign(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ||
         static_cast<unsigned char>(c) > 127;
}

std::string take_name(std::string_view& text) {
  std::size_t n = 0;
  while (n < text.size() && is_name_sign(text[n])) ++n;
  const std::string name(text.substr(0, n));
  text.remove_prefix(n);
  return name;
}

enum class Match { kKnown, kNever, kUnknown };

/// Reads one selector. kNever: it matches only while a pointer or the keyboard is used, or boxes that SVG
/// does not have.
Match read_selector(std::string_view text, std::vector<CompoundSelector>& out) {
  constexpr std::array<std::string_view, 11> kNever{"hover",  "active",       "focus",   "focus-visible",
                                                    "target", "focus-within", "visited", "selection",
                                                    "before", "after",        "backdrop"};
  text = trimmed(text);
  if (text.empty()) return Match::kUnknown;
  Combinator step = Combinator::kDescendant;
  while (true) {
    CompoundSelector one;
    one.to_left = step;
    const std::size_t before = text.size();
    if (text.starts_with('*'))
      text.remove_prefix(1);
    else
      one.element = take_name(text);
    while (!text.empty() && (text[0] == '.' || text[0] == '#' || text[0] == ':')) {
      const char sign = text[0];
      text.remove_prefix(text.starts_with("::") ? 2 : 1);
      const std::string name = take_name(text);
      if (name.empty()) return Match::kUnknown;
      if (sign == '.') one.classes.push_back(name);
      if (sign == '#') one.ids.push_back(name);
      if (sign != ':') continue;
      if (std::find(kNever.begin(), kNever.end(), lowercase(name)) != kNever.end()) return Match::kNever;
      if (lowercase(name) != "root") return Match::kUnknown;
      one.root = true;
    }
    if (text.size() == before) return Match::kUnknown;
    out.push_back(std::move(one));
    const std::string_view rest = trimmed(text);
    if (rest.empty()) return Match::kKnown;
    if (rest.size() == text.size() && rest[0] != '>') return Match::kUnknown;
    step = rest[0] == '>' ? Combinator::kChild : Combinator::kDescendant;
    text = rest[0] == '>' ? trimmed(rest.substr(1)) : rest;
  }
}

bool has_class(const Element& element, std::string_view name) {
  std::string_view all = element["class"].value_or("");
  while (true) {
    all = trimmed(all);
    if (all.empty()) return false;
    const std::size_t end = std::min(all.size(), all.find_first_of(" \t\r\n\f"));
    if (all.substr(0, end) == name) return true;
    all.remove_prefix(end);
  }
}

bool matches(const CompoundSelector& one, const Element& element) {
  if (!one.element.empty() && one.element != element.name) return false;
  if (one.root && element.parent != nullptr) return false;
  return std::all_of(one.ids.begin(), one.ids.end(),
                     [&](const std::string& id) { return element["id"].value_or("") == id; }) &&
         std::all_of(one.classes.begin(), one.classes.end(),
                     [&](const std::string& name) { return has_class(element, name); });
}

/// Says whether the selector matches the element and those around it.
bool matches(const std::vector<CompoundSelector>& selector, const Element& element) {
  if (!matches(selector.back(), element)) return false;
  std::vector<const Element*> line;  // from the outermost element to this one
  for (const Element* e = &element; e != nullptr; e = e->parent) line.push_back(e);
  std::reverse(line.begin(), line.end());
  std::vector<char> reached(line.size(), 1);  // elements that the selector matches so far
  for (std::size_t k = 0; k < selector.size(); ++k) {
    const bool child = selector[k].to_left == Combinator::kChild;
    bool above = k == 0, any = above;  // the part to the left matches the element above, or any further out
    for (std::size_t i = 0; i < line.size(); ++i) {
      const bool left = reached[i] != 0;
      reached[i] = (child && k > 0 ? above : any) && matches(selector[k], *line[i]);
      if (k == 0) continue;
      above = left;
      any = any || left;
    }
  }
  return reached.back() != 0;
}

/// Ids, classes, names.
std::tuple<std::size_t, std::size_t, std::size_t> specificity(const std::vector<CompoundSelector>& selector) {
  std::size_t ids = 0, classes = 0, names = 0;
  for (const CompoundSelector& one : selector) {
    ids += one.ids.size();
    classes += one.classes.size() + (one.root ? 1 : 0);
    names += one.element.empty() ? 0 : 1;
  }
  return {ids, classes, names};
}

std::string key_of(const CompoundSelector& one) {
  if (!one.ids.empty()) return "#" + one.ids.front();
  if (!one.classes.empty()) return "." + one.classes.front();
  return one.element.empty() ? "*" : one.element;
}

}  // namespace

Cascade::Cascade(const Document& document, std::size_t& line) {
  for (const Element& element : document.elements) {
    if (element.name != "style") continue;
    line = element.line;
    const std::string type = lowercase(trimmed(element["type"].value_or(""))),
                      media = lowercase(trimmed(element["media"].value_or("")));
    if (!type.empty() && type != "text/css") continue;
    if (media.empty() || media == "all" || media == "screen")
      read_sheet(element.text);
    else
      read_sheet("@media " + media + "{" + element.text + "}");
  }
}

void Cascade::read_sheet(std::string_view text) { read_rules(without_comments(text), false); }

void Cascade::read_rules(std::string_view text, bool is_nested) {
  constexpr std::array<std::string_view, 8> kPassedOver{"@charset",  "@namespace",          "@font-face",
                                                        "@page",     "@keyframes",          "@counter-style",
                                                        "@property", "@font-feature-values"};
  while (!(text = trimmed(text)).empty()) {
    const bool at_rule = text.starts_with('@');
    const std::size_t begin = find_outside(text, at_rule ? "{;" : "{");
    const std::string_view head = trimmed(text.substr(0, begin));
    if (begin == text.size() && !at_rule) refuse(head, "is no rule: a { is needed");
    const bool has_block = begin < text.size() && text[begin] == '{';
    const std::size_t end = has_block ? find_outside(text, "}", begin + 1) : begin;
    const std::string_view block = has_block ? text.substr(begin + 1, end - begin - 1) : std::string_view();
    text.remove_prefix(std::min(text.size(), end + 1));
    if (!at_rule) {
      add_rule(head, block);
      continue;
    }
    std::string name = lowercase(head.substr(0, head.find_first_of(" \t\r\n(\"'")));
    if (name.ends_with("keyframes")) name = "@keyframes";
    if (std::find(kPassedOver.begin(), kPassedOver.end(), name) != kPassedOver.end()) continue;
    if (name == "@import") refuse(head, "is not read: put the rules into the file");
    const std::string media = lowercase(trimmed(head.substr(std::min(head.size(), name.size()))));
    if (name == "@media" && !is_nested && (media == "all" || media == "screen")) {
      read_rules(block, true);
      continue;
    }
    if (sets_property(block)) refuse(head, "is not read: it decides what is drawn");
  }
}

void Cascade::add_rule(std::string_view selectors, std::string_view block) {
  std::vector<Declaration> list = declarations(block);
  if (list.empty()) return;
  lists_.push_back(std::move(list));
  split(selectors, ',', [&](std::string_view one) {
    Rule rule;
    rule.declarations = lists_.size() - 1;
    const Match match = read_selector(one, rule.selector);
    if (match == Match::kUnknown)
      refuse(one, fmt::format("is not read, but sets {}: names, .classes and #ids are",
                              lists_.back()[0].property));
    if (match == Match::kNever) return;
    by_key_[key_of(rule.selector.back())].push_back(rules_.size());
    rules_.push_back(std::move(rule));
  });
}

Properties Cascade::of(const Element& element) const {
  /// Origin (attribute, sheet, style attribute, then the important ones), specificity, place.
  using Rank = std::tuple<int, std::tuple<std::size_t, std::size_t, std::size_t>, std::size_t>;
  std::map<std::string_view, Rank> ranks;
  Properties out;
  for (const auto& [name, value] : element.attributes) {
    const Property* const property = property_named(name);
    if (property == nullptr || !property->is_attribute || trimmed(value).empty()) continue;
    out.set(property->name, {std::string(trimmed(value)), false});
    ranks[property->name] = {};
  }
  const auto declare = [&](const Declaration& d, int origin, const auto& weight, std::size_t place) {
    const Rank rank{origin + (d.important ? 2 : 0), weight, place};
    const std::string_view name = property_named(d.property)->name;
    const auto [found, is_new] = ranks.emplace(name, rank);
    if (!is_new && rank < found->second) return;
    found->second = rank;
    out.set(name, {d.value, true});
  };
  const auto look = [&](std::string_view key) {
    const auto found = by_key_.find(key);
    if (found == by_key_.end()) return;
    for (const std::size_t i : found->second)
      if (const Rule& rule = rules_[i]; matches(rule.selector, element))
        for (const Declaration& d : lists_[rule.declarations]) declare(d, 1, specificity(rule.selector), i);
  };
  look("*");
  look(element.name);
  if (const auto id = element["id"]) look("#" + std::string(*id));
  std::string_view classes = trimmed(element["class"].value_or(""));
  while (!classes.empty()) {
    const std::size_t end = std::min(classes.size(), classes.find_first_of(" \t\r\n\f"));
    look("." + std::string(classes.substr(0, end)));
    classes = trimmed(classes.substr(end));
  }
  const std::vector<Declaration> own = declarations(without_comments(element["style"].value_or("")));
  for (std::size_t i = 0; i < own.size(); ++i)
    declare(own[i], 2, std::tuple<std::size_t, std::size_t, std::size_t>{}, i);
  return out;
}

}  // namespace firn::svg
