#include "tests/drivers/vplus_machine.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

namespace firn::drivers::test {
namespace {

using Value = VplusMachine::Value;

Value number_value(double n) { return {false, n, {}}; }
Value text_value(std::string text) { return {true, 0.0, std::move(text)}; }
Value truth_value(bool yes) { return number_value(yes ? -1.0 : 0.0); }

std::string trimmed_line(std::string_view line) {
  bool quoted = false;
  std::size_t end = 0;
  for (; end < line.size() && (quoted || line[end] != ';'); ++end) quoted ^= line[end] == '"';
  line = line.substr(0, end);
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.front()))) line.remove_prefix(1);
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.remove_suffix(1);
  return std::string(line);
}

/// Parts between commas that stand in no bracket and no string.
std::vector<std::string> split_arguments(std::string_view text) {
  std::vector<std::string> parts;
  std::string part;
  int depth = 0;
  bool quoted = false;
  for (const char c : text) {
    quoted ^= c == '"';
    depth += quoted ? 0 : (c == '(' || c == '[') - (c == ')' || c == ']');
    if (c == ',' && depth == 0 && !quoted) {
      parts.push_back(trimmed_line(part));
      part.clear();
    } else {
      part += c;
    }
  }
  if (!trimmed_line(part).empty()) parts.push_back(trimmed_line(part));
  return parts;
}

/// The text behind the first bracket of a statement: `READ (…) $piece`.
std::string after_bracket(const std::string& line) { return trimmed_line(line.substr(line.find(')') + 1)); }

/// Reads one expression: OR, AND, NOT, comparisons, sums, products, functions of strings.
class Expression {
 public:
  using Lookup = std::function<Value(const std::string&)>;
  Expression(std::string_view text, const Lookup& variable, int iostat)
      : text_(text), variable_(variable), iostat_(iostat) {}
  Value read() {
    Value v = either();
    skip();
    if (at_ != text_.size()) refuse();
    return v;
  }

 private:
  [[noreturn]] void refuse() const {
    throw std::runtime_error("V+: '" + std::string(text_) + "' is not understood at " + std::to_string(at_));
  }
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  bool take(std::string_view token) {
    skip();
    if (!text_.substr(at_).starts_with(token)) return false;
    const char next = at_ + token.size() < text_.size() ? text_[at_ + token.size()] : ' ';
    if (std::isalpha(static_cast<unsigned char>(token[0])) && std::isalnum(static_cast<unsigned char>(next)))
      return false;
    at_ += token.size();
    return true;
  }
  Value either() {
    Value v = both();
    while (take("OR")) {
      const Value w = both();
      v = truth_value(v.number != 0.0 || w.number != 0.0);
    }
    return v;
  }
  Value both() {
    Value v = negated();
    while (take("AND")) {
      const Value w = negated();
      v = truth_value(v.number != 0.0 && w.number != 0.0);
    }
    return v;
  }
  Value negated() {
    if (take("NOT")) return truth_value(negated().number == 0.0);
    return compared();
  }
  Value compared() {
    const Value v = sum();
    for (const std::string_view sign : {"==", "<>", "<=", ">=", "<", ">"}) {
      if (!take(sign)) continue;
      const Value w = sum();
      const double order = v.is_text ? double(v.text.compare(w.text)) : v.number - w.number;
      return truth_value(sign == "=="   ? order == 0.0
                         : sign == "<>" ? order != 0.0
                         : sign == "<=" ? order <= 0.0
                         : sign == ">=" ? order >= 0.0
                         : sign == "<"  ? order < 0.0
                                        : order > 0.0);
    }
    return v;
  }
  Value sum() {
    Value v = primary();
    for (;;) {
      if (take("+")) {
        const Value w = primary();
        v = v.is_text ? text_value(v.text + w.text) : number_value(v.number + w.number);
      } else if (take("-")) {
        v = number_value(v.number - primary().number);
      } else {
        return v;
      }
    }
  }
  Value primary() {
    skip();
    if (at_ == text_.size()) refuse();
    if (take("-")) return number_value(-primary().number);
    if (take("(")) {
      Value v = either();
      if (!take(")")) refuse();
      return v;
    }
    if (text_[at_] == '"') {
      const std::size_t end = text_.find('"', at_ + 1);
      if (end == std::string_view::npos) refuse();
      const Value v = text_value(std::string(text_.substr(at_ + 1, end - at_ - 1)));
      at_ = end + 1;
      return v;
    }
    std::size_t end = at_;
    while (end < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[end])) || text_[end] == '.' ||
                                  text_[end] == '$' || text_[end] == '_'))
      ++end;
    const std::string word(text_.substr(at_, end - at_));
    if (word.empty()) refuse();
    at_ = end;
    if (std::isdigit(static_cast<unsigned char>(word[0]))) return number_value(std::stod(word));
    if (word == "TRUE" || word == "FALSE") return truth_value(word == "TRUE");
    if (at_ < text_.size() && text_[at_] == '(') return function(word);
    return variable_(word);
  }
  Value function(const std::string& name) {
    std::vector<Value> a;
    ++at_;
    while (!take(")")) {
      a.push_back(either());
      take(",");
    }
    const auto place = [](const Value& v) { return std::size_t(std::max(1.0, v.number)) - 1; };
    if (name == "IOSTAT") return number_value(iostat_);
    if (name == "LEN") return number_value(double(a.at(0).text.size()));
    if (name == "$CHR") return text_value(std::string(1, char(a.at(0).number)));
    if (name == "ASC")
      return number_value(place(a.at(1)) < a[0].text.size()
                              ? double(static_cast<unsigned char>(a[0].text[place(a[1])]))
                              : -1.0);
    if (name == "POS") {
      const std::size_t at = a.at(0).text.find(a.at(1).text, a.size() > 2 ? place(a[2]) : 0);
      return number_value(at == std::string::npos ? 0.0 : double(at + 1));
    }
    if (name == "$MID") {
      if (place(a.at(1)) >= a[0].text.size() || a.at(2).number <= 0.0) return text_value({});
      return text_value(a[0].text.substr(place(a[1]), std::size_t(a[2].number)));
    }
    if (name == "$INTB" || name == "$ERROR") return text_value({});
    refuse();
  }

  std::string_view text_;
  const Lookup& variable_;
  int iostat_;
  std::size_t at_ = 0;
};

}  // namespace

void VplusNetwork::open(std::size_t arguments) {
  opened = arguments == 1;
  iostat = opened ? 1 : kNoDevice;
}

bool VplusNetwork::read(std::string& text) {
  text.clear();
  if (coming.empty()) return false;
  Event& next = coming.front();
  if (!opened || (next.status == kCame && place_taken)) {  // no other is let in
    iostat = opened ? kNothing : kNoDevice;
    coming.pop_front();
    while (opened && !coming.empty() && coming.front().status != kCame) coming.pop_front();
    return true;
  }
  if (next.status != 0) {
    iostat = next.status;
    place_taken = true;
    coming.pop_front();
    return true;
  }
  iostat = 1;
  text = next.bytes.substr(0, kMaxOfARead);
  next.bytes.erase(0, text.size());
  if (next.bytes.empty()) coming.pop_front();
  return true;
}

VplusMachine::VplusMachine(std::string_view source, VplusNetwork& network) : network_(network) {
  Program* program = nullptr;
  std::vector<std::size_t> open;
  while (!source.empty()) {
    const std::size_t end = std::min(source.find('\n'), source.size());
    const std::string line = trimmed_line(source.substr(0, end));
    source.remove_prefix(std::min(end + 1, source.size()));
    if (line.starts_with(".PROGRAM")) {
      const std::size_t bracket = line.find('(');
      program = &programs_[trimmed_line(line.substr(8, bracket - 8))];
      program->parameters = split_arguments(line.substr(bracket + 1, line.rfind(')') - bracket - 1));
      open.clear();
    } else if (line.starts_with(".END")) {
      program = nullptr;
    } else if (program && !line.empty()) {
      const std::size_t at = program->lines.size();
      program->lines.push_back(line);
      program->other.push_back(0);
      program->end.push_back(0);
      program->loop.push_back(0);
      for (const std::size_t o : open)
        if (program->lines[o].starts_with("WHILE ")) program->loop.back() = o;
      if (line.starts_with("IF ") || line.starts_with("WHILE ") || line.starts_with("CASE ") ||
          line.starts_with("FOR ")) {
        open.push_back(at);
      } else if (line == "ELSE") {
        program->other[open.back()] = at;
      } else if (line.starts_with("VALUE ") || line == "ANY") {
        program->other[at] = open.back();
      } else if (line == "END") {
        const std::size_t begin = open.back();
        open.pop_back();
        program->end[begin] = program->end[at] = at;
        if (program->other[begin] == 0)
          program->other[begin] = at;
        else
          program->end[program->other[begin]] = at;
        program->loop[at] = begin;
      }
    }
  }
}

void VplusMachine::run(const std::string& name) {
  Frame frame;
  try {
    execute(programs_.at(name), frame);
  } catch (const Over&) {
  }
}

VplusMachine::Value* VplusMachine::find(const std::string& name, Frame& frame) {
  const auto local = frame.find(name);
  return local != frame.end() ? &local->second : &global_[name];
}

VplusMachine::Value VplusMachine::evaluate(std::string_view text, Frame& frame) {
  const Expression::Lookup variable = [&](const std::string& name) {
    Value v = *find(name, frame);
    v.is_text = name[0] == '$';
    return v;
  };
  return Expression(text, variable, network_.iostat).read();
}

/// The line of the CASE's branch, or its END.
std::size_t VplusMachine::chosen(const Program& program, std::size_t at, Frame& frame) {
  const std::string& line = program.lines[at];
  const double selector = evaluate(std::string_view(line).substr(4, line.rfind(' ') - 4), frame).number;
  for (std::size_t n = at + 1; n < program.end[at]; ++n) {
    const std::string& branch = program.lines[n];
    if (program.other[n] != at || (branch != "ANY" && !branch.starts_with("VALUE "))) continue;
    if (branch == "ANY") return n;
    for (const std::string& value : split_arguments(std::string_view(branch).substr(6, branch.size() - 7)))
      if (evaluate(value, frame).number == selector) return n;
  }
  return program.end[at];
}

void VplusMachine::execute(const Program& program, Frame& frame) {
  for (std::size_t at = 0; at < program.lines.size(); ++at) {
    const std::string& line = program.lines[at];
    if (line.starts_with("IF ") || line.starts_with("WHILE ")) {
      const std::size_t from = line.find(' ');
      if (evaluate(std::string_view(line).substr(from, line.rfind(' ') - from), frame).number == 0.0)
        at = program.other[at];
    } else if (line == "ELSE") {
      at = program.end[at];
    } else if (line.starts_with("CASE ")) {
      at = chosen(program, at, frame);
    } else if (line.starts_with("VALUE ") || line == "ANY") {  // the branch before is over
      at = program.end[program.other[at]];
    } else if (line == "END") {
      if (program.lines[program.loop[at]].starts_with("WHILE ")) at = program.loop[at] - 1;
    } else if (line == "NEXT") {
      at = program.loop[at] - 1;
    } else if (line == "RETURN") {
      return;
    } else {
      statement(line, frame);
    }
  }
}

void VplusMachine::statement(const std::string& line, Frame& frame) {
  const std::string word = line.substr(0, line.find(' '));
  constexpr int kForEver = 100;
  if (word == "WAIT") {
    if (++waits_ > kForEver) throw Over{};
    return;
  }
  // A FOR's body is run once: it sets one value after the other to nothing.
  if (word == "TIMER" || word == "SIGNAL" || word == "EXECUTE" || word == "FOR") return;
  if (word == "AUTO") {
    for (const std::string& name : split_arguments(line.substr(4))) frame[name] = {};
  } else if (word == "CALL") {
    call(line, frame);
  } else if (word == "TYPE") {
    typed.push_back(line);
  } else if (word == "SELECT") {
    selected_ = true;
  } else if (line == "ATTACH ()") {
    attached_ = selected_;
  } else if (word == "CALIBRATE") {
    (attached_ ? moved : refused).push_back(line);
  } else if (word == "ATTACH") {
    network_.iostat = 1;
  } else if (word == "FOPEN") {
    network_.open(split_arguments(after_bracket(line)).size());
  } else if (word == "FCMND") {
    if (line.find(", 600)") != std::string::npos) network_.place_taken = false;
  } else if (word == "READ") {
    std::string text;
    if (!network_.read(text)) throw Over{};
    *find(after_bracket(line), frame) = text_value(std::move(text));
  } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
    Value v = evaluate(std::string_view(line).substr(equals + 3), frame);
    *find(line.substr(0, equals), frame) = std::move(v);
  } else {
    throw std::runtime_error("V+: '" + line + "' is not known");
  }
}

// Arguments that are variables are handed back.
void VplusMachine::call(const std::string& line, Frame& frame) {
  const std::size_t bracket = line.find('(');
  const std::string name = trimmed_line(line.substr(4, bracket - 4));
  const std::vector<std::string> given =
      split_arguments(line.substr(bracket + 1, line.rfind(')') - bracket - 1));
  std::vector<Value> arguments;
  for (const std::string& text : given) arguments.push_back(evaluate(text, frame));
  if (const auto outside = outside_.find(name); outside != outside_.end()) {
    outside->second(arguments);
  } else {
    const Program& program = programs_.at(name);
    Frame inner;
    for (std::size_t n = 0; n < arguments.size(); ++n) inner[program.parameters.at(n)] = arguments[n];
    execute(program, inner);
    for (std::size_t n = 0; n < arguments.size(); ++n) arguments[n] = inner[program.parameters[n]];
  }
  const auto is_name = [](const std::string& text) {
    return std::ranges::all_of(text, [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '$'; });
  };
  for (std::size_t n = 0; n < given.size(); ++n)
    if (is_name(given[n]) && !std::isdigit(static_cast<unsigned char>(given[n][0])))
      *find(given[n], frame) = arguments[n];
}

}  // namespace firn::drivers::test
