// StatementParser reads the lines of one V+ program into its statements and sets the jumps of IF, CASE, FOR
// and WHILE.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "plant/twins/vplus/code.h"
#include "plant/twins/vplus/expression_parser.h"

namespace firn::plant::vplus {

class StatementParser {
 public:
  /// @param program with its parameters
  StatementParser(Code& code, Program& program);
  /// @throws std::invalid_argument for a line that is not understood
  void line(std::uint32_t number, std::string_view text);
  void end(std::uint32_t number);  ///< .END

 private:
  struct Block {
    enum class Kind : std::uint8_t { kIf, kElse, kWhile, kFor, kCase } kind = Kind::kIf;
    std::uint32_t begin = 0;
    std::vector<std::uint32_t> to_end, to_next;  ///< jumps whose targets are set at its END
    std::uint32_t branch = 0;                    ///< of a CASE: its last VALUE
    bool has_branch = false, is_over = false;    ///< is_over: ANY was read
  };

  Statement& add(Verb verb, std::vector<Expression> values = {});
  std::uint32_t here() const { return std::uint32_t(program_.statements.size()); }
  void open(Block::Kind kind);
  Block& innermost();
  Block& loop();  ///< the innermost FOR or WHILE
  void statement(const std::string& word);
  bool structure(const std::string& word);
  bool motion(const std::string& word);
  bool device(const std::string& word);
  void declare();
  void assign();
  void call();
  void for_loop();
  void value_branch(bool any);
  void finish_block();
  Lasting lasting();
  std::uint32_t program_named(const std::string& name) const;
  std::vector<Expression> values();

  Code& code_;
  Program& program_;
  std::map<std::string, std::uint32_t> locals_;
  ExpressionParser read_;
  std::vector<Block> blocks_;
  std::uint32_t number_ = 0;
};

}  // namespace firn::plant::vplus
