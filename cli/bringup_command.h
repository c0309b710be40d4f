// run_bringup carries out the hardware checklist on a lab's instruments and keeps the findings.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct BringupOptions {
  std::string lab;                     ///< lab or experiment file
  std::string node;                    ///< only this instrument; empty: all
  int row = -1;                        ///< only this row; -1: all
  bool again = false;                  ///< also rows that are done
  std::vector<std::string> answers;    ///< ROW=yes, ROW=no: instead of asking
  std::string result;                  ///< file; empty: LAB.bringup.json
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  bool json = false;
};

/// @returns 0 no row has failed, 1 one has
int run_bringup(const BringupOptions& options);

/// Declares the arguments.
void declare_bringup(OptionSet& options);

}  // namespace firn
