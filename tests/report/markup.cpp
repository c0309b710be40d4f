#include "tests/report/markup.h"

#include <png.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>

namespace firn::test {
namespace {

[[noreturn]] void fail(std::size_t at, const std::string& why) {
  throw std::runtime_error("byte " + std::to_string(at) + ": " + why);
}

void check_utf8(std::string_view s) {
  for (std::size_t n = 0; n < s.size();) {
    const auto c = static_cast<unsigned char>(s[n]);
    const std::size_t length = c < 0x80                ? 1
                               : c >= 0xC2 && c < 0xE0 ? 2
                               : c >= 0xE0 && c < 0xF0 ? 3
                               : c >= 0xF0 && c < 0xF5 ? 4
                                                       : 0;
    if (length == 0 || n + length > s.size()) fail(n, "no UTF-8");
    for (std::size_t k = 1; k < length; ++k)
      if ((static_cast<unsigned char>(s[n + k]) & 0xC0) != 0x80) fail(n + k, "no UTF-8");
    n += length;
  }
}

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Element document() {
    check_utf8(text_);
    Element root;
    if (text_.substr(0, 15) == "<!doctype html>") at_ = 15;
    inside(root);
    if (at_ != text_.size()) fail(at_, "an end without its beginning");
    return root;
  }

 private:
  bool next_is(std::string_view word) const { return text_.substr(at_, word.size()) == word; }

  static bool name_character(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == ':';
  }

  std::string name() {
    const std::size_t from = at_;
    while (at_ < text_.size() && name_character(text_[at_])) ++at_;
    if (at_ == from) fail(at_, "a name is missing");
    return std::string(text_.substr(from, at_ - from));
  }

  void spaces() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }

  std::string decoded(char end) {
    static const std::map<std::string, std::string> kEntities{
        {"amp", "&"}, {"lt", "<"}, {"gt", ">"}, {"quot", "\""}};
    std::string s;
    for (; at_ < text_.size() && text_[at_] != end; ++at_) {
      if (text_[at_] == '<') fail(at_, "a bare <");
      if (text_[at_] != '&') {
        s += text_[at_];
        continue;
      }
      const std::size_t semicolon = text_.find(';', at_);
      const auto entity = kEntities.find(std::string(text_.substr(at_ + 1, semicolon - at_ - 1)));
      if (semicolon == text_.npos || entity == kEntities.end()) fail(at_, "a bare &");
      s += entity->second;
      at_ = semicolon;
    }
    return s;
  }

  // Children and text up to the end tag of the parent.
  void inside(Element& parent) {
    if (parent.name == "style") {
      const std::size_t end = text_.find("</style>", at_);
      if (end == text_.npos) fail(at_, "style without an end");
      parent.text = text_.substr(at_, end - at_);
      at_ = end;
      return;
    }
    while (at_ < text_.size() && !next_is("</")) {
      if (text_[at_] == '<')
        parent.children.push_back(element());
      else
        parent.text += decoded('<');
    }
  }

  Element element() {
    static const std::set<std::string> kVoid{"meta", "br", "hr", "link", "img"};
    Element e;
    ++at_;
    e.name = name();
    for (spaces(); at_ < text_.size() && name_character(text_[at_]); spaces()) {
      const std::string key = name();
      if (!next_is("=\"")) fail(at_, key + " has no value in quotes");
      at_ += 2;
      if (!e.attributes.emplace(key, decoded('"')).second) fail(at_, key + " twice");
      ++at_;
    }
    if (next_is("/>")) {
      at_ += 2;
      return e;
    }
    if (!next_is(">")) fail(at_, "<" + e.name + "> does not close");
    ++at_;
    if (kVoid.contains(e.name)) return e;
    inside(e);
    if (!next_is("</" + e.name + ">")) fail(at_, "<" + e.name + "> has no end here");
    at_ += e.name.size() + 3;
    return e;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

void collect(const Element& e, const std::string& name, const std::string& key, const std::string& value,
             std::vector<const Element*>& out) {
  for (const Element& child : e.children) {
    if (child.name == name && (key.empty() || child.attribute(key) == value)) out.push_back(&child);
    collect(child, name, key, value, out);
  }
}

double number_of(const std::string& text) {
  std::size_t used = 0;
  const double v = std::stod(text, &used);
  if (used != text.size() || !std::isfinite(v)) throw std::runtime_error("no finite number: " + text);
  return v;
}

}  // namespace

std::string Element::attribute(const std::string& key) const {
  const auto found = attributes.find(key);
  return found == attributes.end() ? "" : found->second;
}

double Element::at(const std::string& key) const { return number_of(attribute(key)); }

std::string Element::all_text() const {
  std::string s = text;
  for (const Element& child : children) s += child.all_text();
  return s;
}

std::vector<const Element*> Element::all(const std::string& wanted, const std::string& key,
                                         const std::string& value) const {
  std::vector<const Element*> out;
  collect(*this, wanted, key, value, out);
  return out;
}

const Element& Element::only(const std::string& wanted, const std::string& key,
                             const std::string& value) const {
  const std::vector<const Element*> found = all(wanted, key, value);
  if (found.size() != 1)
    throw std::runtime_error(std::to_string(found.size()) + " elements <" + wanted + ">, not one");
  return *found.front();
}

Element parse_markup(std::string_view text) { return Parser(text).document(); }

std::vector<std::vector<PixelPoint>> polylines_of(const std::string& d) {
  std::vector<std::vector<PixelPoint>> lines;
  PixelPoint at;
  std::size_t n = 0;
  const auto take = [&] {
    while (n < d.size() && d[n] == ' ') ++n;
    std::size_t end = n;
    while (end < d.size() &&
           (std::isdigit(static_cast<unsigned char>(d[end])) || d[end] == '.' || (d[end] == '-' && end == n)))
      ++end;
    const double v = number_of(d.substr(n, end - n));
    n = end;
    return v;
  };
  while (n < d.size()) {
    const char word = d[n++];
    const PixelPoint before = at;
    switch (word) {
      case 'M':
        lines.emplace_back();
        [[fallthrough]];
      case 'L':
        at.x = take();
        at.y = take();
        break;
      case 'l':
        at.x += take();
        at.y = before.y + take();
        break;
      case 'H':
        at.x = take();
        break;
      case 'h':
        at.x += take();
        break;
      case 'V':
        at.y = take();
        break;
      case 'v':
        at.y += take();
        break;
      case 'Z':
      case 'z':
        if (lines.empty()) throw std::runtime_error("Z before M in " + d);
        at = lines.back().front();
        break;
      default:
        throw std::runtime_error("letter in a path: " + d);
    }
    if (lines.empty()) throw std::runtime_error("a path without M: " + d);
    lines.back().push_back(at);
  }
  return lines;
}

ReadAxis::ReadAxis(std::vector<double> px, std::vector<double> values, bool logarithmic)
    : px_(std::move(px)), values_(std::move(values)), logarithmic_(logarithmic) {
  if (px_.size() < 2) throw std::runtime_error("an axis with fewer than two ticks");
}

double ReadAxis::value(double px) const {
  const double a = logarithmic_ ? std::log10(values_.front()) : values_.front(),
               b = logarithmic_ ? std::log10(values_.back()) : values_.back(),
               v = a + (b - a) * (px - px_.front()) / (px_.back() - px_.front());
  return logarithmic_ ? std::pow(10.0, v) : v;
}

double ReadAxis::per_px(double px) const { return std::abs(value(px + 0.5) - value(px - 0.5)); }

ReadAxis x_axis_of(const Element& svg) {
  std::vector<double> px, values;
  for (const Element* t : svg.all("text", "class", "tick"))
    if (t->attribute("text-anchor") == "middle") {
      px.push_back(t->at("x"));
      values.push_back(printed_number(t->text));
    }
  return {px, values, false};
}

ReadAxis y_axis_of(const Element& svg, bool logarithmic) {
  std::vector<double> px, values;
  for (const Element* t : svg.all("text", "class", "tick"))
    if (t->attribute("text-anchor") == "end") {
      px.push_back(t->at("y") - 4.0);  // the text's middle, not its base line
      values.push_back(printed_number(t->text));
    }
  return {px, values, logarithmic};
}

ReadPicture picture_of(std::string_view bytes) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()))
    throw std::runtime_error(image.message);
  image.format = PNG_FORMAT_RGBA;
  ReadPicture p{int(image.width), int(image.height), {}};
  p.pixels.resize(std::size_t(image.width) * image.height);
  if (!png_image_finish_read(&image, nullptr, p.pixels.data(), 0, nullptr))
    throw std::runtime_error(image.message);
  return p;
}

ReadPicture picture_of(const Element& image) {
  const std::string href = image.attribute("href"), head = "data:image/png;base64,";
  if (href.substr(0, head.size()) != head) throw std::runtime_error("an image that is not embedded");
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : href.substr(head.size())) {
    if (c == '=') break;
    const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (digit < 0) throw std::runtime_error("not base 64");
    group = group << 6 | std::uint32_t(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += char(group >> bits & 0xFF);
  }
  if ((href.size() - head.size()) % 4 != 0) throw std::runtime_error("base 64 without its padding");
  return picture_of(std::string_view(bytes));
}

std::vector<std::vector<std::string>> csv_rows(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string cell;
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (text[n] == '"') {
      if (!cell.empty()) throw std::runtime_error("a quote inside a cell");
      for (++n; n < text.size(); ++n) {
        if (text[n] == '"' && n + 1 < text.size() && text[n + 1] == '"')
          ++n;
        else if (text[n] == '"')
          break;
        cell += text[n];
      }
      if (n + 1 >= text.size() || (text[n + 1] != ',' && text[n + 1] != '\n'))
        throw std::runtime_error("a quote inside a cell");
    } else if (text[n] == ',' || text[n] == '\n') {
      row.push_back(std::move(cell));
      cell.clear();
      if (text[n] == ',') continue;
      if (!rows.empty() && row.size() != rows.front().size())
        throw std::runtime_error("rows of different length");
      rows.push_back(std::move(row));
      row.clear();
    } else {
      cell += text[n];
    }
  }
  if (!cell.empty() || !row.empty()) throw std::runtime_error("the last line does not end");
  return rows;
}

std::vector<std::vector<std::string>> table_rows(const Element& table) {
  std::vector<std::vector<std::string>> rows;
  for (const Element* tr : table.all("tr")) {
    rows.emplace_back();
    for (const Element& cell : tr->children) rows.back().push_back(cell.all_text());
  }
  return rows;
}

double printed_number(std::string text) {
  const std::string minus = "−";
  if (text.substr(0, minus.size()) == minus) text = "-" + text.substr(minus.size());
  return number_of(text);
}

}  // namespace firn::test
