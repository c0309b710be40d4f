// run_dataflow writes docs/dataflow.md from the channel table and the nodes' subscriptions.
#pragma once

#include <string>

namespace firn {

struct Product;

struct DataflowOptions {
  std::string output = "docs/dataflow.md";  ///< "-" = stdout
  bool json = false;                        ///< the table as JSON on stdout; writes no file
};

int run_dataflow(const Product& product, const DataflowOptions& options);

/// The document: a Mermaid graph and the table of channels.
std::string dataflow_markdown(const Product& product);

}  // namespace firn
