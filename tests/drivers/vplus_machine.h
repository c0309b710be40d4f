// VplusMachine runs the statements of the robot's V+ program that a network and an arm see: ATTACH, FOPEN,
// READ, IOSTAT and FCMND against a VplusNetwork, SELECT and CALIBRATE, with assignments, strings, IF, WHILE,
// CASE, FOR and CALL between them. Source: the V+ Language Reference Guide and the AdeptNet guide.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace firn::drivers::test {

/// Simulates the TCP device of V+: FOPEN takes one string; a READ gives all that has come, at most 128
/// characters, without regard for lines; a client that is gone keeps its place until FCMND 600.
struct VplusNetwork {
  static constexpr int kNothing = -526, kNoDevice = -508, kCame = 100, kGone = 101;
  static constexpr std::size_t kMaxOfARead = 128;
  struct Event {
    int status = 0;  ///< kCame, kGone, or 0 for bytes
    std::string bytes;
  };
  std::deque<Event> coming;
  bool opened = false, place_taken = false;
  int iostat = 0;

  void open(std::size_t arguments);
  /// @returns false when nothing will come any more
  bool read(std::string& text);
};

class VplusMachine {
 public:
  struct Value {
    bool is_text = false;
    double number = 0.0;
    std::string text;
  };
  /// A program of the machine's surroundings, by name; its arguments can be changed.
  using Outside = std::function<void(std::vector<Value>& arguments)>;

  /// @param source .PROGRAM to .END, several times
  VplusMachine(std::string_view source, VplusNetwork& network);
  void provide(const std::string& name, Outside outside) { outside_[name] = std::move(outside); }
  /// Runs a program without arguments until it returns or waits for a network on which nothing will come.
  /// @throws std::runtime_error naming the statement that is not known
  void run(const std::string& name);
  void set(const std::string& name, Value value) { global_[name] = std::move(value); }

  std::vector<std::string> typed;           ///< by TYPE, as written in the program
  std::vector<std::string> moved, refused;  ///< motions of an attached arm; without one

 private:
  struct Program {
    std::vector<std::string> parameters, lines;
    std::vector<std::size_t> other, end,
        loop;  ///< of each line: its ELSE, CASE or END, its END, the WHILE around it
  };
  using Frame = std::map<std::string, Value>;
  struct Over {};  ///< nothing will come any more, or it waits for ever

  Value* find(const std::string& name, Frame& frame);
  void execute(const Program& program, Frame& frame);
  std::size_t chosen(const Program& program, std::size_t at, Frame& frame);
  void statement(const std::string& line, Frame& frame);
  void call(const std::string& line, Frame& frame);
  Value evaluate(std::string_view text, Frame& frame);

  VplusNetwork& network_;
  std::map<std::string, Program> programs_;
  std::map<std::string, Outside> outside_;
  Frame global_;
  bool selected_ = false, attached_ = false;
  int waits_ = 0;
};

}  // namespace firn::drivers::test
