// Reading V+ programs line by line into statements and jumps.

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "plant/twins/vplus/code.h"
#include "plant/twins/vplus/expression_parser.h"
#include "plant/twins/vplus/statement_parser.h"

namespace firn::plant::vplus {
namespace {

constexpr std::size_t kLongestText = 1 << 20;  ///< bytes: a bound of the parser's own memory
constexpr std::size_t kLongestLine = 512;      ///< characters: so deep can an expression's tree be

std::string where(const Source& source, std::uint32_t line) {
  return source.file + ":" + std::to_string(line) + ": ";
}

/// Calls `each` with the number and the text of each line.
template <class Each>
void for_each_line(const Source& source, Each each) {
  if (source.text.size() > kLongestText) throw std::invalid_argument(source.file + ": more than 1 MiB");
  std::string_view rest = source.text;
  for (std::uint32_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    try {
      if (end > kLongestLine) throw std::invalid_argument("more than 512 characters");
      each(line, rest.substr(0, end));
    } catch (const std::invalid_argument& e) {
      throw std::invalid_argument(where(source, line) + e.what());
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

std::string_view without_blanks(std::string_view line) {
  while (!line.empty() && (line[0] == ' ' || line[0] == '\t')) line.remove_prefix(1);
  return line;
}

void add_program(Code& code, std::string_view line, const std::string& file) {
  std::vector<Token> tokens = tokens_of(line.substr(std::string_view(".PROGRAM").size()));
  std::size_t at = 0;
  const auto name = [&] {
    if (tokens[at].kind != Token::Kind::kName) throw std::invalid_argument("a name is missing");
    return tokens[at++].text;
  };
  const auto sign = [&](std::string_view s) {
    const bool is = tokens[at].kind == Token::Kind::kSign && tokens[at].text == s;
    at += is;
    return is;
  };
  Program p;
  p.name = name();
  p.file = file;
  if (!sign("(")) throw std::invalid_argument("'(' is missing");
  while (!sign(")")) {
    if (!p.locals.empty() && !sign(",")) throw std::invalid_argument("',' is missing");
    p.locals.push_back(name());
    p.local_types.push_back(type_of_name(p.locals.back()));
  }
  p.parameters = std::uint32_t(p.locals.size());
  if (!code.program_of.emplace(p.name, code.programs.size()).second)
    throw std::invalid_argument("program " + p.name + " is there twice");
  code.programs.push_back(std::move(p));
}

}  // namespace

Code parse(const std::vector<Source>& sources) {
  Code code;
  for (const Source& source : sources)
    for_each_line(source, [&](std::uint32_t, std::string_view line) {
      if (line.starts_with(".PROGRAM")) add_program(code, line, source.file);
    });
  std::size_t next = 0;
  for (const Source& source : sources) {
    std::unique_ptr<StatementParser> program;
    for_each_line(source, [&](std::uint32_t number, std::string_view line) {
      if (line.starts_with(".PROGRAM")) {
        if (program) throw std::invalid_argument("the program before has no .END");
        program = std::make_unique<StatementParser>(code, code.programs[next++]);
      } else if (line.starts_with(".END")) {
        if (!program) throw std::invalid_argument("no program is begun");
        program->end(number);
        program.reset();
      } else if (program) {
        program->line(number, without_blanks(line));
      } else if (!tokens_of(line).front().text.empty()) {
        throw std::invalid_argument("a statement outside of a program");
      }
    });
    if (program) throw std::invalid_argument(source.file + ": the last program has no .END");
  }
  return code;
}

}  // namespace firn::plant::vplus
