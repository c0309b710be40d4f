// PathReader reads a text by one of the readers of path files.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "files/path/path_file.h"
#include "files/usage_error.h"

namespace firn::test {

template <auto read_paths>
struct PathReader {
  const char* file;

  std::vector<InputPath> operator()(const std::string& text) const {
    std::istringstream in(text);
    std::vector<InputPath> paths;
    read_paths(in, file, double(text.size()), [&](InputPath&& p) { paths.push_back(std::move(p)); });
    return paths;
  }

  std::vector<std::string> notes(const std::string& text) const {
    std::istringstream in(text);
    std::vector<std::string> sentences;
    read_paths(in, file, double(text.size()),
               PathSink([](InputPath&&) {}, [&](const std::string& one) { sentences.push_back(one); }));
    return sentences;
  }

  /// The error's text; empty if there is none.
  std::string refusal(const std::string& text) const {
    try {
      (*this)(text);
    } catch (const UsageError& e) {
      return e.what();
    }
    return {};
  }
};

}  // namespace firn::test
