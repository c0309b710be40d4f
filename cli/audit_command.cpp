// run_audit audits a run (replay/audit_run.h).
#include "cli/commands.h"

#include <cstdio>
#include <string>

#include "cli/option_set.h"
#include "files/digest.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/import/imported_run.h"
#include "replay/audit_run.h"
#include "runs/folder/run_lock.h"

namespace firn {
namespace {

struct AuditCommandOptions {
  std::string run;   ///< run folder
  std::string seal;  ///< digest that one of the run's seals must have; empty: any
  bool json = false;
};

/// @returns 0 clean, 1 any violation, 2 usage
int run_audit(const AuditCommandOptions& options) {
  if (!options.seal.empty() && !is_sha256_hex(options.seal))
    throw UsageError("--seal '" + options.seal.substr(0, 100) + "': is no SHA-256, 64 hexadecimal digits");
  const runs::RunLock still(options.run, runs::RunUse::kRead);
  refuse_imported(options.run, "firn audit");
  const replay::AuditVerdict verdict = replay::audit_run(options.run, options.seal);
  const std::string text = options.json ? replay::to_json(verdict) + "\n" : replay::to_text(verdict);
  std::fputs(text.c_str(), stdout);
  return verdict.clean() ? kOk : kFailed;
}

}  // namespace

void declare_audit(OptionSet& options) {
  auto& o = options.calls(run_audit);
  options.option("RUN", o.run, "run folder").required();
  options.option("--seal", o.seal,
                 "DIGEST that one of the run's seals must have, as an earlier audit printed it");
  options.json_flag(o.json);
}

}  // namespace firn
