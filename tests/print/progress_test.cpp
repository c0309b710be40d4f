// The line about a print on terminals of any width, and messages beside it.
#include "print/progress.h"

#include <catch2/catch.hpp>

#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace firn {
namespace {

layer_metrics_t metrics(int layer, int expected) {
  layer_metrics_t m{};
  m.layer = layer;
  m.layers_expected = expected;
  m.mean_height_mm = 0.0076 * layer;
  m.rms_mm = 0.00123;
  return m;
}

/// The text that `write` puts on a terminal of so many columns.
template <class Write>
std::string on_terminal(int columns, Write write) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  REQUIRE(terminal >= 0);
  ::grantpt(terminal);
  ::unlockpt(terminal);
  const std::string name = ::ptsname(terminal);
  const winsize size{24, static_cast<unsigned short>(columns), 0, 0};
  const pid_t child = ::fork();
  if (child == 0) {
    const int fd = ::open(name.c_str(), O_RDWR | O_NOCTTY);
    ::ioctl(fd, TIOCSWINSZ, &size);
    ::dup2(fd, STDERR_FILENO);
    write();
    ::_exit(0);
  }
  std::string text;
  char chunk[1024];
  const int slave = ::open(name.c_str(), O_RDWR | O_NOCTTY);  // until everything is read
  int status = 0;
  ::waitpid(child, &status, 0);
  ::fcntl(terminal, F_SETFL, O_NONBLOCK);
  for (ssize_t n; (n = ::read(terminal, chunk, sizeof chunk)) > 0;) text.append(chunk, std::size_t(n));
  ::close(slave);
  ::close(terminal);
  return text;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0, now = 0;
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (text[n] == '\r' || text[n] == '\n') {
      now = 0;
    } else if (text.compare(n, 3, "\033[K") == 0) {
      n += 2;
    } else {
      longest = std::max(longest, ++now);
    }
  }
  return longest;
}

TEST_CASE("the line about a layer fits every width, and layer and RMS are the last to go") {
  for (int columns = 30; columns < 140; ++columns) {
    const std::string text = layer_text("a-long-name", LabWords{}, metrics(7, 26), 12.0, columns);
    INFO(columns << ": " << text);
    if (columns > 45) CHECK(int(text.size()) < columns);
    CHECK_THAT(text, Catch::Contains("layer   7/26") && Catch::Contains("RMS"));
    if (columns >= 60) CHECK_THAT(text, Catch::Contains("ETA 12 s"));
    if (columns >= 120) CHECK_THAT(text, Catch::Contains("[#####") && Catch::Contains("a-long-name"));
  }
}

TEST_CASE("layers beyond the expected number have no time left to show") {
  const std::string text = on_terminal(100, [] {
    PrintProgress progress("mpc", {});
    for (int layer = 24; layer < 40; ++layer) {
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
      progress.layer(metrics(layer, 26));
    }
    progress.done();
  });
  CHECK_THAT(text, Catch::Contains("layer  39, 26 expected"));
  CHECK_THAT(text.substr(text.find("layer  26")), !Catch::Contains("ETA"));
}

TEST_CASE("a terminal of 60 columns never wraps, and messages have lines of their own") {
  const std::string text = on_terminal(60, [] {
    PrintProgress progress("a-long-name-of-a-scheme", {});
    progress.layer(metrics(1, 2000));
    progress.note("the operator: pause");
    progress.layer(metrics(2, 2000));
    progress.done();
  });
  INFO(text);
  CHECK(longest_line(text) < 60);
  CHECK_THAT(text, Catch::Contains("\r\033[Kthe operator: pause\r\n"));
  CHECK_THAT(text.substr(text.find("pause\r\n") + 7),
             Catch::Contains("layer   1") && Catch::Contains("layer   2"));
}

TEST_CASE("the time that is left counts the layers since the print or its resume began") {
  const std::string text = on_terminal(120, [] {
    PrintProgress progress("smf", {});
    progress.layer(metrics(900, 1000));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    progress.layer(metrics(901, 1000));
    progress.done();
  });
  const std::size_t at = text.find("ETA ");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(text.substr(at + 4)) >= 15.0);  // 99 layers of at least 0.2 s
}

TEST_CASE("A pause does not count in the time that is left") {
  const auto seconds_left = [](bool paused) {
    const std::string text = on_terminal(120, [&] {
      PrintProgress progress("smf", {});
      progress.layer(metrics(1, 101));
      if (paused) progress.note("the print waits before layer 2, as the operator asked");
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      if (paused) progress.note("the print goes on");
      progress.layer(metrics(2, 101));
      progress.done();
    });
    const std::size_t at = text.rfind("ETA ");
    REQUIRE(at != std::string::npos);
    return std::stod(text.substr(at + 4));
  };
  CHECK(seconds_left(false) >= 29.0);  // 99 layers of at least 0.3 s
  CHECK(seconds_left(true) < 29.0);
}

TEST_CASE("The progress of a study names its results by their own word") {
  const std::string text = on_terminal(120, [] {
    StudyProgress progress(3, "case");
    progress.made(3, 1);
    progress.done();
  });
  CHECK_THAT(text, Catch::Contains("3/3 cases, 1 failed, ") && Catch::Contains(" cases/s"));
}

}  // namespace
}  // namespace firn
