#include "tests/cli/run_firn.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "cli/commands.h"
#include "cli/failure.h"
#include "cli/options.h"
#include "print/labs/full_product.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;

// Sends a file descriptor into a file while it lives.
class Caught {
 public:
  Caught(int fd, const fs::path& file) : fd_(fd), file_(file), saved_(::dup(fd)) {
    flush();
    const int to = ::open(file.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    ::dup2(to, fd_);
    ::close(to);
  }
  std::string text() {
    flush();
    ::dup2(saved_, fd_);
    ::close(saved_);
    return file_text(file_);
  }

 private:
  static void flush() {
    std::cout.flush();
    std::cerr.flush();
    std::fflush(stdout);
    std::fflush(stderr);
  }
  int fd_;
  fs::path file_;
  int saved_;
};

}  // namespace

Said firn_says(const std::vector<std::string>& words) {
  std::vector<const char*> argv{"firn"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  const fs::path folder = fs::path(FIRN_BINARY_DIR) / "scratch";
  fs::create_directories(folder);
  const std::string id = std::to_string(::getpid());
  Caught out(STDOUT_FILENO, folder / (id + ".out")), err(STDERR_FILENO, folder / (id + ".err"));
  Said said;
  std::string problem;
  try {
    said.code = parse_command_line(all_commands(), full_product(), int(argv.size()), argv.data()).run();
  } catch (const std::exception& e) {
    const Failure f = failure_of(e);
    said.code = f.code;
    problem = f.line;
  }
  said.err = err.text() + problem;
  said.out = out.text();
  fs::remove(folder / (id + ".out"));
  fs::remove(folder / (id + ".err"));
  return said;
}

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::path(FIRN_BINARY_DIR) / "scratch" / ("cli-" + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

fs::path golden(const std::string& name) {
  return fs::path(FIRN_SOURCE_DIR) / "tests" / "replay" / "golden" / name;
}

fs::path golden_copy(const std::string& name, const std::string& folder) {
  const fs::path copy = fresh_folder(folder) / name;
  fs::copy(golden(name), copy, fs::copy_options::recursive);
  return copy;
}

std::string file_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

void write_file_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

}  // namespace firn::test
