// run_command starts another program, waits for its end and returns what it said.
#pragma once

#include <atomic>
#include <string>
#include <vector>

namespace firn {

struct CommandEnd {
  int code = 0;        ///< exit code; 127: the program is not installed; 128 + n: ended by signal n
  std::string output;  ///< of its standard output
  std::string errors;  ///< of its standard error

  bool missing() const { return code == 127; }
  /// Returns the last line of what it said, errors first, or "exit code N".
  std::string reason() const;
};

/// Standard input is empty. The whole output is held in memory.
/// @param words the program, found by PATH, and its arguments, which no shell reads
/// @param stop once it is set the program gets SIGTERM, and after a second again
/// @throws std::runtime_error naming the program and the system's reason: it cannot be started
CommandEnd run_command(std::vector<std::string> words, const std::atomic<bool>* stop = nullptr);

/// Returns a word as a POSIX shell reads it: in single quotes unless it is plain.
std::string shell_word(const std::string& word);

}  // namespace firn
