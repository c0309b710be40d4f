// ExitCode holds the exit codes of the firn program, as every command returns them to the shell;
// kExitMeanings says each in words. docs/exit-codes.md has the same words.
#pragma once

namespace firn {

enum ExitCode : int {
  kOk = 0,
  kFailed = 1,          ///< the run failed, or the comparison differs
  kUsage = 2,           ///< usage or configuration
  kSafetyStop = 3,      ///< an instrument's fault or a safety stop
  kOutOfTolerance = 4,  ///< the print ran to its end, but the part is not as wanted
  kInterrupted = 130,   ///< Ctrl-C; the lab was made safe first
};

struct ExitMeaning {
  ExitCode code;
  const char* meaning;
};
inline constexpr ExitMeaning kExitMeanings[] = {
    {kOk, "done; what was compared is the same, what was checked is sound"},
    {kFailed, "something differs, is damaged or could not be computed"},
    {kUsage, "a mistake in the command line, in a configuration or in an input file; nothing was begun"},
    {kSafetyStop,
     "an instrument failed or does not answer, or a print was stopped safely; it can be resumed"},
    {kOutOfTolerance, "the print ran to its end, but the part is out of tolerance"},
    {kInterrupted, "interrupted by Ctrl-C; the lab was made safe first"},
};

}  // namespace firn
