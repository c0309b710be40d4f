#include "plant/twins/vplus/statement_parser.h"

#include <stdexcept>

namespace firn::plant::vplus {
namespace {

constexpr std::size_t kDeepestBlock = 20;  ///< IFs within IFs

}  // namespace

StatementParser::StatementParser(Code& code, Program& program)
    : code_(code), program_(program), read_(code, locals_) {
  for (std::uint32_t n = 0; n < program.locals.size(); ++n)
    if (!locals_.emplace(program.locals[n], n).second)
      throw std::invalid_argument("two parameters of one name");
}

Statement& StatementParser::add(Verb verb, std::vector<Expression> values) {
  Statement s;
  s.verb = verb;
  s.line = number_;
  s.values = std::move(values);
  program_.statements.push_back(std::move(s));
  return program_.statements.back();
}

void StatementParser::open(Block::Kind kind) {
  if (blocks_.size() == kDeepestBlock) throw std::invalid_argument("blocks are too deep");
  blocks_.emplace_back();
  blocks_.back().kind = kind;
  blocks_.back().begin = here();
}

StatementParser::Block& StatementParser::innermost() {
  if (blocks_.empty()) throw std::invalid_argument("no block is open");
  return blocks_.back();
}

StatementParser::Block& StatementParser::loop() {
  for (std::size_t n = blocks_.size(); n-- > 0;)
    if (blocks_[n].kind == Block::Kind::kFor || blocks_[n].kind == Block::Kind::kWhile) return blocks_[n];
  throw std::invalid_argument("no loop is open");
}

void StatementParser::line(std::uint32_t number, std::string_view text) {
  number_ = number;
  read_.begin(tokens_of(text));
  if (read_.at_end()) return;
  if (read_.token().kind != Token::Kind::kName) read_.refuse("a statement is missing");
  statement(read_.token().text);
  if (!read_.at_end()) read_.refuse("more than the statement");
}

void StatementParser::end(std::uint32_t number) {
  number_ = number;
  if (!blocks_.empty()) throw std::invalid_argument("END is missing");
  add(Verb::kReturn);
}

void StatementParser::statement(const std::string& word) {
  if (word[0] == '$' || word[0] == '#' || (word[0] >= 'a' && word[0] <= 'z')) return assign();
  if (!structure(word) && !motion(word) && !device(word)) read_.refuse("this statement is not known");
}

void StatementParser::assign() {
  const Expression to = read_.variable();
  read_.require("=");
  const Expression value = read_.expression();
  if (read_.type_of(to) != read_.type_of(value)) read_.refuse("types do not fit");
  add(Verb::kAssign, {to, value});
}

void StatementParser::declare() {
  do {
    const std::string name = read_.token().text;
    if (read_.token().kind != Token::Kind::kName || locals_.contains(name)) read_.refuse("no new name");
    read_.advance();
    if (read_.take("[")) {
      read_.real();
      read_.require("]");
    }
    locals_[name] = std::uint32_t(program_.locals.size());
    program_.locals.push_back(name);
    program_.local_types.push_back(type_of_name(name));
  } while (read_.take(","));
}

std::vector<Expression> StatementParser::values() {
  std::vector<Expression> v;
  do v.push_back(read_.expression());
  while (read_.take(","));
  return v;
}

std::uint32_t StatementParser::program_named(const std::string& name) const {
  const auto found = code_.program_of.find(name);
  if (found == code_.program_of.end()) throw std::invalid_argument("no program is called " + name);
  return found->second;
}

void StatementParser::call() {
  const std::uint32_t to = program_named(read_.token().text);
  read_.advance();
  std::vector<Expression> given;
  if (read_.take("(") && !read_.take(")")) {
    given = values();
    read_.require(")");
  }
  const Program& p = code_.programs[to];
  if (given.size() != p.parameters)
    read_.refuse(p.name + " takes " + std::to_string(p.parameters) + " arguments");
  for (std::size_t n = 0; n < given.size(); ++n)
    if (read_.type_of(given[n]) != p.local_types[n])
      read_.refuse("types do not fit the parameters of " + p.name);
  add(Verb::kCall, std::move(given)).target = to;
}

void StatementParser::for_loop() {
  const Expression variable = read_.variable();
  read_.require("=");
  const Expression first = read_.real();
  read_.require("TO");
  const Expression last = read_.real();
  std::vector<Expression> v{variable, first, last};
  if (read_.type_of(variable) != Type::kReal) read_.refuse("a FOR counts with a number");
  if (read_.take("STEP")) v.push_back(read_.real());
  open(Block::Kind::kFor);
  Statement& s = add(Verb::kForBegin, std::move(v));
  s.slot = program_.slots++;
}

void StatementParser::value_branch(bool any) {
  Block& b = innermost();
  if (b.kind != Block::Kind::kCase || b.is_over) throw std::invalid_argument("no CASE is open here");
  if (b.has_branch) {
    b.to_end.push_back(here());
    add(Verb::kJump);
    program_.statements[b.branch].target = here();
  }
  b.has_branch = !any;
  b.is_over = any;
  if (any) {
    add(Verb::kNothing);
    return;
  }
  const std::uint32_t slot = program_.statements[b.begin].slot;
  b.branch = here();
  std::vector<Expression> list = values();
  for (const Expression e : list)
    if (read_.type_of(e) != Type::kReal) read_.refuse("a CASE compares numbers");
  add(Verb::kBranch, std::move(list)).slot = slot;
  read_.require(":");
}

void StatementParser::finish_block() {
  Block b = std::move(innermost());
  blocks_.pop_back();
  const std::uint32_t at = here();
  switch (b.kind) {
    case Block::Kind::kWhile:
      add(Verb::kJump).target = b.begin;
      break;
    case Block::Kind::kFor: {
      Statement next;
      next.values = {program_.statements[b.begin].values[0]};
      next.slot = program_.statements[b.begin].slot;
      Statement& s = add(Verb::kForNext, next.values);
      s.slot = next.slot;
      s.target = b.begin + 1;
      break;
    }
    default:
      add(Verb::kNothing);
      break;
  }
  const bool loops = b.kind == Block::Kind::kWhile || b.kind == Block::Kind::kFor;
  const std::uint32_t past = at + 1;
  if (b.kind == Block::Kind::kCase) {
    if (b.has_branch) program_.statements[b.branch].target = at;
  } else if (b.kind != Block::Kind::kElse) {
    program_.statements[b.begin].target = loops ? past : at;
  }
  for (const std::uint32_t jump : b.to_end) program_.statements[jump].target = loops ? past : at;
  for (const std::uint32_t jump : b.to_next) program_.statements[jump].target = at;
}

bool StatementParser::structure(const std::string& w) {
  read_.advance();
  if (w == "AUTO") {
    declare();
  } else if (w == "IF" || w == "WHILE") {
    const Expression condition = read_.real();
    read_.require(w == "IF" ? "THEN" : "DO");
    open(w == "IF" ? Block::Kind::kIf : Block::Kind::kWhile);
    add(Verb::kUnless, {condition});
  } else if (w == "ELSE") {
    Block& b = innermost();
    if (b.kind != Block::Kind::kIf) throw std::invalid_argument("no IF is open here");
    b.kind = Block::Kind::kElse;
    b.to_end.push_back(here());
    add(Verb::kJump);
    program_.statements[b.begin].target = here();
  } else if (w == "FOR") {
    for_loop();
  } else if (w == "CASE") {
    const Expression selector = read_.real();
    read_.require("OF");
    open(Block::Kind::kCase);
    add(Verb::kCase, {selector}).slot = program_.slots++;
  } else if (w == "VALUE" || w == "ANY") {
    value_branch(w == "ANY");
  } else if (w == "END") {
    finish_block();
  } else if (w == "EXIT" || w == "NEXT") {
    (w == "EXIT" ? loop().to_end : loop().to_next).push_back(here());
    add(Verb::kJump);
  } else if (w == "CALL") {
    call();
  } else if (w == "RETURN") {
    add(Verb::kReturn);
  } else if (w == "RETURNE") {
    add(Verb::kResume);
  } else if (w == "REACTE") {
    const std::uint32_t to = program_named(read_.token().text);
    if (code_.programs[to].parameters != 0) read_.refuse("a program of REACTE takes no arguments");
    read_.advance();
    add(Verb::kOnError).target = to;
  } else if (w == "EXECUTE") {
    const Expression task = read_.real();
    const std::uint32_t to = program_named(read_.token().text);
    if (code_.programs[to].parameters != 0) read_.refuse("a task's program takes no arguments here");
    read_.advance();
    read_.require("(");
    read_.require(")");
    add(Verb::kExecute, {task}).target = to;
  } else if (w == "WAIT") {
    add(Verb::kWait);
  } else if (w == "TIMER") {
    const Expression number = read_.real();
    read_.require("=");
    add(Verb::kTimer, {number, read_.real()});
  } else if (w == "SIGNAL") {
    std::vector<Expression> numbers = values();
    for (const Expression e : numbers)
      if (read_.type_of(e) != Type::kReal) read_.refuse("a signal has a number");
    add(Verb::kSignal, std::move(numbers));
  } else {
    return false;
  }
  return true;
}

Lasting StatementParser::lasting() {
  return read_.take("ALWAYS") ? kAlways : read_.take("MONITOR") ? kMonitor : kNextMotion;
}

// The word itself has been taken by structure().
bool StatementParser::motion(const std::string& w) {
  if (w == "MOVE") {
    const Expression to = read_.expression();
    if (read_.type_of(to) != Type::kPoint) read_.refuse("MOVE goes to a precision point here");
    add(Verb::kMove, {to});
  } else if (w == "HERE") {
    const Expression to = read_.variable();
    if (read_.type_of(to) != Type::kPoint) read_.refuse("HERE sets a precision point here");
    add(Verb::kHere, {to});
  } else if (w == "DECOMPOSE") {
    const Expression to = read_.variable();
    read_.require("=");
    const Expression from = read_.expression();
    if (read_.type_of(to) != Type::kReal || read_.type_of(from) != Type::kPoint ||
        code_.nodes[to].children.size() != 1)
      read_.refuse("DECOMPOSE sets an array of numbers from a point");
    add(Verb::kDecompose, {to, from});
  } else if (w == "SPEED" || w == "DURATION") {
    const Expression value = read_.real();
    add(w == "SPEED" ? Verb::kSpeed : Verb::kDuration, {value}).target = lasting();
    if (w == "DURATION" && program_.statements.back().target == kMonitor)
      read_.refuse("a DURATION is no monitor's");
  } else if (w == "NULL" || w == "NONULL") {
    lasting();
    add(Verb::kNull);
  } else if (w == "BREAK") {
    add(Verb::kBreak);
  } else if (w == "BRAKE") {
    add(Verb::kBrake);
  } else if (w == "CALIBRATE") {
    add(Verb::kCalibrate);
  } else if (w == "ENABLE" || w == "DISABLE") {
    read_.require("POWER");
    add(Verb::kPower).target = w == "ENABLE";
  } else if (w == "SELECT") {
    read_.require("ROBOT");
    read_.require("=");
    add(Verb::kSelect, {read_.real()});
  } else {
    return false;
  }
  return true;
}

bool StatementParser::device(const std::string& w) {
  const auto two_numbers = [&] {
    read_.require("(");
    std::vector<Expression> v{read_.real()};
    read_.require(",");
    v.push_back(read_.real());
    return v;
  };
  if (w == "ATTACH") {
    if (read_.ahead().kind == Token::Kind::kSign && read_.ahead().text == ")") {
      read_.require("(");
      read_.require(")");
      add(Verb::kAttachRobot);
      return true;
    }
    std::vector<Expression> v = two_numbers();
    read_.require(")");
    v.push_back(read_.text());
    add(Verb::kAttach, std::move(v));
  } else if (w == "FOPEN" || w == "FCMND") {
    std::vector<Expression> v = two_numbers();
    read_.require(")");
    v.push_back(read_.text());
    while (w == "FOPEN" && read_.take(",")) v.push_back(read_.text());  // the device refuses a second one
    add(w == "FOPEN" ? Verb::kOpen : Verb::kCommand, std::move(v));
  } else if (w == "READ") {
    std::vector<Expression> v = two_numbers();
    v.push_back(read_.take(",") ? read_.real() : read_.constant(Value::of(0.0F)));
    read_.require(")");
    v.push_back(read_.variable());
    if (read_.type_of(v.back()) != Type::kString || code_.nodes[v[1]].op != Operator::kVariable)
      read_.refuse("READ sets a handle and a string");
    add(Verb::kRead, std::move(v));
  } else if (w == "WRITE") {
    std::vector<Expression> v = two_numbers();
    read_.require(")");
    bool ends = true;
    do {
      if (read_.take("/")) {
        if (!read_.take("S")) read_.refuse("this format is not known");
        ends = false;
      } else {
        v.push_back(read_.text());
      }
    } while (read_.take(","));
    add(Verb::kWrite, std::move(v)).target = ends;
  } else if (w == "TYPE") {
    std::vector<Expression> v = values();
    add(Verb::kType, std::move(v));
  } else {
    return false;
  }
  return true;
}

}  // namespace firn::plant::vplus
