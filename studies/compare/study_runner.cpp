#include "studies/compare/study_runner.h"

#include <map>
#include <span>

#include "config/error.h"
#include "config/fields.h"
#include "config/include.h"
#include "config/study_labs.h"
#include "files/digest.h"
#include "files/nearest.h"
#include "files/run_paths.h"
#include "print/inputs/ice_inputs.h"
#include "print/labs/full_product.h"
#include "report/run/differing_parameters.h"
#include "runs/folder/run_folder.h"

namespace firn {
namespace {

std::size_t metric_index(const StudyLab& lab, const std::string& name, const std::string& file) {
  std::vector<std::string_view> names;
  std::string known;
  for (std::size_t m = 0; m < lab.metrics.size(); ++m) {
    if (lab.metrics[m].name == name) return m;
    names.push_back(lab.metrics[m].name);
    known += (known.empty() ? "" : ", ") + lab.metrics[m].name;
  }
  const std::string near = nearest(name, names);
  throw ConfigError(
      file, 0, "metrics",
      "metrics: '" + name + "' is not one of " + known + (near.empty() ? "" : "; the nearest is " + near));
}

// The part of a run on record, whose target may come from others; nothing of it may be changed then.
void take_part(const Experiment& recorded, const Blobs& of_run, const Experiment& e, Blobs& inputs,
               const std::string& study_file) {
  for (const report::DifferingParameter& changed : report::differing_parameters({recorded, e}))
    if (changed.key.starts_with("part.") || changed.key.starts_with("grid."))
      throw ConfigError(study_file, 0, changed.key,
                        changed.key + ": the part is that of the recorded run, as it was measured");
  for (Blob& input : inputs)
    if (input.role == "target" || input.role == "mask") input = blob(of_run, input.role);
}

}  // namespace

std::string digest_of(const Experiment& e, const Blobs& inputs) {
  std::string all = dump(e);
  for (const Blob& b : inputs)
    all += b.role + " " + (b.sha256.empty() ? sha256_hex(b.bytes) : b.sha256) + "\n";
  return sha256_hex(std::as_bytes(std::span(all)));
}

Experiment StudyPlan::experiment(const StudyCell& cell) const {
  Experiment e = experiments[at(cell.arm, cell.part)];
  lab->set_seed(e, study.seeds[cell.seed]);
  draw_lab(study, cell.part, study.seeds[cell.seed], e);
  return e;
}

StudyPrint StudyPlan::make(const StudyCell& cell) const {
  return lab->print(experiment(cell), *inputs[at(cell.arm, cell.part)], edge_bound);
}

StudyPlan plan_study(Study study, const std::filesystem::path& folder, const StudyLab& lab,
                     const std::string& file) {
  StudyPlan plan;
  plan.lab = &lab;
  plan.experiments = study_experiments(study, folder);
  for (const std::string& name : study.metrics.empty() ? lab.usual : study.metrics) {
    plan.metrics.push_back(metric_index(lab, name, file));
    plan.edge_bound = plan.edge_bound || name == kEdgeBound;
  }
  // An image's path is relative to the experiment file.
  const std::filesystem::path beside = study_experiment_file(study, folder).parent_path();
  const bool of_run = !study.experiment.empty() && std::filesystem::is_directory(folder / study.experiment);
  const Blobs recorded = of_run ? runs::RunFolder::open(beside).inputs() : Blobs();
  std::map<std::string, std::shared_ptr<const Blobs>> known;
  for (Experiment& e : plan.experiments) {
    lab.check(e);
    Blobs inputs = make_inputs(full_product(), e, beside);
    if (of_run) take_part(load_experiment(RunPaths(beside).experiment_path()), recorded, e, inputs, file);
    complete_experiment(full_product(), e, inputs);
    std::string key;
    for (const Blob& b : inputs) key += b.role + b.sha256;
    auto& shared = known[key];
    if (!shared) shared = std::make_shared<const Blobs>(std::move(inputs));
    plan.inputs.push_back(shared);
  }
  plan.study = std::move(study);
  plan.name = plan.study.name;
  plan.values = lab.metrics;
  plan.parts.clear();
  for (const StudyEntry& arm : plan.study.arms) plan.kinds.push_back(arm.name);
  for (const StudyEntry& part : plan.study.parts) plan.parts.push_back(part.name);
  plan.seeds = plan.study.seeds;
  // A print is its experiment under another seed and the seed's lab. These are a few words beside the
  // thousands of the experiment, which is written once.
  std::vector<std::string> of_arm;
  for (std::size_t n = 0; n < plan.experiments.size(); ++n) {
    Experiment e = plan.experiments[n];
    const std::size_t part = n % plan.study.parts.size();
    check_labs(plan.study, part, e);
    lab.set_seed(e, 0);
    draw_lab(plan.study, part, 0, e);
    of_arm.push_back(digest_of(e, *plan.inputs[n]) + (plan.edge_bound ? "with its bound\n" : ""));
  }
  for (std::size_t s = 0; s < plan.study.seeds.size(); ++s)
    for (std::size_t p = 0; p < plan.study.parts.size(); ++p) {
      std::string of_seed = "seed " + std::to_string(plan.study.seeds[s]) + "\n";
      for (const std::string& drawn : drawn_lab(plan.study, p, plan.study.seeds[s])) of_seed += drawn + "\n";
      for (std::size_t a = 0; a < plan.study.arms.size(); ++a) {
        const std::string whole = of_arm[plan.at(a, p)] + of_seed;
        plan.cells.push_back({a, p, s, sha256_hex(std::as_bytes(std::span(whole)))});
      }
    }
  return plan;
}

report::StudyTable study_table(const StudyPlan& plan, const StudyJournal& journal) {
  report::StudyTable t;
  t.name = plan.study.name;
  for (const StudyEntry& a : plan.study.arms) t.arms.push_back(a.name);
  for (const StudyEntry& p : plan.study.parts) t.parts.push_back(p.name);
  t.seeds = plan.study.seeds;
  t.baseline = plan.study.baseline;
  t.judged = plan.study.judged;
  t.margin = plan.study.margin;
  t.profile = plan.lab->profile;
  for (const std::size_t m : plan.metrics) t.metrics.push_back(plan.lab->metrics[m]);
  t.runs.resize(plan.cells.size());
  for (const StudyCell& c : plan.cells) {
    const StudyPrint* print = journal.find(c.digest);
    if (!print) throw std::logic_error("study: a print is not on record");
    report::StudyRun& r = t.runs[(c.arm * t.parts.size() + c.part) * t.seeds.size() + c.seed];
    r.finished = print->finished;
    r.outcome = print->outcome;
    r.reason = print->reason;
    r.profile = print->profile;
    r.within = print->within;
    for (const std::size_t m : plan.metrics) r.metrics.push_back(print->metrics[m]);
  }
  return t;
}

std::vector<report::DifferingParameter> differing_arms(const StudyPlan& plan) {
  std::vector<Experiment> experiments;
  for (std::size_t a = 0; a < plan.study.arms.size(); ++a)
    experiments.push_back(plan.experiments[plan.at(a, 0)]);
  return report::differing_parameters(std::move(experiments));
}

std::vector<report::DifferingParameter> differing_parts(const StudyPlan& plan) {
  std::vector<Experiment> experiments;
  for (std::size_t p = 0; p < plan.study.parts.size(); ++p)
    experiments.push_back(plan.experiments[plan.at(0, p)]);
  return report::differing_parameters(std::move(experiments));
}

}  // namespace firn
