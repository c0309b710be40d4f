// Code holds the V+ programs of a text as trees of expressions and lists of statements with their jumps.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "plant/twins/vplus/value.h"

namespace firn::plant::vplus {

enum class Operator : std::uint8_t {
  kConstant,
  kVariable,  ///< children: its indices
  kFunction,
  kNegative,
  kNot,
  kComplement,
  kTimes,
  kOver,
  kModulo,
  kAnd,
  kBitAnd,
  kPlus,
  kMinus,
  kOr,
  kBitOr,
  kExclusiveOr,
  kBitExclusiveOr,
  kLess,
  kLessEqual,
  kEqual,
  kUnequal,
  kGreaterEqual,
  kGreater,
  kFormatInteger,  ///< /I0 within $ENCODE
};

enum class Function : std::uint8_t {
  kAbs,
  kAsc,
  kChr,
  kDecode,
  kDefined,
  kEncode,
  kError,
  kErrorText,
  kGetc,
  kInt,
  kIntb,
  kIostat,
  kLen,
  kMax,
  kMid,
  kMin,
  kPdest,
  kPos,
  kPpoint,
  kSign,
  kSpeed,
  kState,
  kSwitchPower,
  kTimer,
  kVal,
};

using Expression = std::uint32_t;  ///< index of a Node
inline constexpr Expression kNoExpression = ~Expression(0);

struct Node {
  Operator op = Operator::kConstant;
  Function function = Function::kAbs;
  bool local = false;        ///< of a variable: a parameter or declared AUTO
  bool in_brackets = false;  ///< a CALL hands over its value
  Type type = Type::kReal;   ///< of its value
  std::uint32_t variable = 0;
  Value constant;
  std::vector<Expression> children;
};

enum class Verb : std::uint8_t {
  kAssign,    ///< variable, value
  kUnless,    ///< condition: jumps where it is false
  kJump,      ///< ELSE, END of a WHILE, EXIT, NEXT
  kForBegin,  ///< variable, first, last [, step]
  kForNext,   ///< variable
  kCase,      ///< selector
  kBranch,    ///< VALUE: jumps where no value equals the selector
  kNothing,   ///< END of an IF, ANY
  kCall,
  kReturn,
  kResume,   ///< RETURNE
  kOnError,  ///< REACTE program
  kWait,
  kExecute,  ///< task
  kSelect,   ///< number of the robot
  kAttachRobot,
  kAttach,   ///< unit, mode, device
  kOpen,     ///< unit, mode, text
  kCommand,  ///< FCMND: unit, code, text
  kRead,     ///< unit, handle, mode, variable
  kWrite,    ///< unit, handle, values
  kType,
  kSignal,
  kTimer,  ///< number, seconds
  kCalibrate,
  kPower,     ///< target 1: ENABLE, 0: DISABLE
  kSpeed,     ///< percent; target: Lasting
  kDuration,  ///< seconds; target: Lasting
  kNull,      ///< NULL and NONULL: accepted, the simulated arm has no settling of its own
  kMove,
  kBreak,
  kBrake,
  kHere,       ///< variable
  kDecompose,  ///< element, point
};

/// The motions for which a SPEED or DURATION holds.
enum Lasting : std::uint32_t { kNextMotion, kAlways, kMonitor };

struct Statement {
  Verb verb = Verb::kNothing;
  std::uint32_t line = 0;    ///< of its file, from 1
  std::uint32_t target = 0;  ///< statement of a jump, program of a call, slot of a FOR or CASE
  std::uint32_t slot = 0;    ///< of a branch: the CASE
  std::vector<Expression> values;
};

struct Program {
  std::string name, file;
  std::vector<std::string> locals;  ///< parameters, then AUTO
  std::vector<Type> local_types;
  std::uint32_t parameters = 0;
  std::uint32_t slots = 0;  ///< FORs and CASEs
  std::vector<Statement> statements;
};

struct Code {
  std::vector<Node> nodes;
  std::vector<Program> programs;
  std::map<std::string, std::uint32_t> program_of, global_of;
  std::vector<Type> global_types;
};

/// A text of V+ programs and the name by which errors call it.
struct Source {
  std::string file, text;
};

/// Reads .PROGRAM to .END, several times.
/// @throws std::invalid_argument naming file, line and the word that is not known
Code parse(const std::vector<Source>& sources);

}  // namespace firn::plant::vplus
