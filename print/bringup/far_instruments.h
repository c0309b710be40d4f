// rows_at_host() carries out rows of the bring-up at the computer where the instrument is.
#pragma once

#include <string>
#include <vector>

#include "print/bringup/bringup.h"

namespace firn {

/// Runs `firn bringup LAB --device NODE --json WORDS` at the host. Nobody is asked there: rows that need a
/// person are open unless WORDS answer them. Returns rows and the instrument's identity.
/// @throws BringupStop naming the host: it is not reached, has no firn, or another one
BringupState rows_at_host(const Experiment& lab, const std::string& host, const std::string& node,
                          const std::vector<std::string>& words);

/// Holds the rows of instruments at other computers, each instrument's fetched once.
class FarRows {
 public:
  /// @param words for all instruments: --again, --row, --answer
  FarRows(const Experiment& lab, std::vector<std::string> words) : lab_(lab), words_(std::move(words)) {}

  /// Whether the row is carried out at another computer: the instrument is there, and no person looks.
  bool has(const PlannedRow& row) const;
  /// Returns the row as the host carried it out, or failed with the reason why it did not.
  BringupResult row(const PlannedRow& row);
  /// Of the instruments whose rows were fetched.
  std::map<std::string, std::string> identities() const;

 private:
  struct Told {
    BringupState state;
    std::string trouble;
  };
  const Experiment& lab_;
  std::vector<std::string> words_;
  std::map<std::string, Told> told_;
};

}  // namespace firn
