// run_help shows a page of the documents, or the sections and keys that a topic is found in.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct HelpOptions {
  std::vector<std::string> topic;  ///< words; empty: the list of pages
};

/// @returns 0, or 1 when nothing mentions the topic
int run_help(const HelpOptions& options);

/// Declares the arguments.
void declare_help(OptionSet& options);

}  // namespace firn
