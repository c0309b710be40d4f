#include "print/simulated/lab_run.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <optional>

#include "config/experiment.h"
#include "config/labs.h"
#include "files/exit_codes.h"
#include "files/record/event_log.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/run_start_t.hpp"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/convert.h"
#include "plant/inkjet/python_model.h"
#include "plant/world/ice_lab.h"
#include "plant/world/kept_world.h"
#include "plant/world/setup.h"
#include "plant/world/world.h"
#include "print/folder/taking_part.h"
#include "print/operator/operator_desk.h"
#include "print/print_judge.h"
#include "print/run_facts.h"
#include "print/simulated/paused_clock.h"
#include "print/simulated/plant_world.h"
#include "print/simulated/validity_words.h"
#include "runs/folder/commit.h"
#include "runs/folder/folder_watch.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/lab_lock.h"
#include "runs/folder/log_repair.h"
#include "runs/folder/resume_point.h"
#include "runtime/build_info.h"
#include "runtime/lab.h"
#include "runtime/wal_file.h"

namespace firn {
namespace {

constexpr std::size_t kWalBuffer_bytes = 1 << 16;
constexpr double kSafetyWall_s = 10.0;  // as the launcher waits for the end of a run

std::int64_t stopwatch_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

plant::WorldConfig nature_of(const Experiment& e, const Blobs& inputs, const LabRunOptions& options) {
  plant::WorldConfig config = plant::world_config(e, inputs);
  if (options.nature) options.nature(config);
  return config;
}

plant::World make_world(const runs::RunFolder& run, const plant::WorldConfig& config, bool resume,
                        plant::WorldRecord* record) {
  const auto state = run.world_state_path();
  if (resume && std::filesystem::exists(state)) return plant::World::restore(state, config, record);
  return plant::World(config, record);
}

// Holds a node with its write-ahead file.
struct Member {
  Member(const runs::RunFolder& run, const NamedMaker& maker, const Blobs& inputs, bool resume)
      : wal(run.wal_path(info(maker.id).name), resume, kWalBuffer_bytes),
        host(maker.id, maker.make(run.experiment_toml(), inputs), run.run_id(), &wal) {
    host.set_stopwatch(stopwatch_ns);
  }
  WalFile wal;
  NodeHost host;
  std::int32_t last_head = -1;  // incarnation of the last head in the write-ahead file
};

struct Message {
  std::string_view channel;
  std::vector<std::byte> bytes;
};

/// Each cell as 2 x 2: means over the map's cells stay exact.
GridSpec halved(const GridSpec& g) {
  return {2 * g.nx,
          2 * g.ny,
          0.5 * g.pitch_x_mm,
          0.5 * g.pitch_y_mm,
          g.origin_x_mm - 0.25 * g.pitch_x_mm,
          g.origin_y_mm - 0.25 * g.pitch_y_mm};
}

// Holds the messages that the reliable channels had sent and that each node had received when everything
// died.
struct Afterlife {
  std::map<std::string_view, std::vector<std::vector<std::byte>>> sent;  // channel -> messages by seq
  std::vector<std::map<std::string_view, std::size_t>> received;         // per node: channel -> count
  std::vector<Message> unsent;

  void hand_over(Lab& lab, const std::vector<std::unique_ptr<Member>>& members) {
    for (const Message& m : unsent) sent[m.channel].push_back(m.bytes);
    for (std::size_t n = 0; n < members.size(); ++n)
      for (const auto& [channel, messages] : sent)
        if (find_channel(channel)->delivery == Delivery::kReliable)
          for (std::size_t k = received[n][channel]; k < messages.size(); ++k)
            lab.publish_to(members[n]->host.id(), channel, messages[k]);
  }
};

void restore_all(const runs::RunFolder& run, std::vector<std::unique_ptr<Member>>& members,
                 Afterlife& after) {
  after.received.resize(members.size());
  for (std::size_t n = 0; n < members.size(); ++n) {
    RestoreSinks sinks;
    sinks.head = [&](const WalHead& head) { members[n]->last_head = head.incarnation; };
    sinks.received = [&](std::string_view c, std::span<const std::byte>) {
      ++after.received[n][find_channel(c)->name];
    };
    sinks.sent = [&](std::string_view c, std::span<const std::byte> b) {
      after.sent[find_channel(c)->name].emplace_back(b.begin(), b.end());
    };
    sinks.unsent = [&](std::string_view c, std::span<const std::byte> b) {
      after.unsent.push_back({find_channel(c)->name, {b.begin(), b.end()}});
    };
    restore(members[n]->host, run.run_id(), members[n]->wal, sinks);
  }
}

// A file of the run that cannot be written.
struct Unwritable : std::runtime_error {
  using runtime_error::runtime_error;
};

template <class Write>
void written(Write write) {
  try {
    write();
  } catch (const std::exception& e) {
    const std::string storage = runs::storage_trouble(e);
    throw Unwritable(storage.empty() ? e.what() : storage);
  }
}

template <class Message>
std::optional<Message> newest(const runs::ResumePoint& point, std::string_view channel) {
  const auto last = point.newest.find(std::string(channel));
  Message m{};
  if (last == point.newest.end() || m.decode(last->second.data(), 0, int(last->second.size())) < 0)
    return std::nullopt;
  return m;
}

// The scheduler had finished the part, and the process ended before result.json was there.
std::optional<runs::RunResult> finished_before(const runs::ResumePoint& point, const PrintJudge& judge) {
  const auto end = newest<run_end_t>(point, channels::kRunEnd.name);
  if (!end) return std::nullopt;
  runs::RunResult result = runs::result_of(end->outcome, end->layers, end->reason);
  judge.judge(result);
  return runs::can_go_on(result) ? std::nullopt : std::optional(result);
}

// A live launcher and recorder speak on when the nodes have ended.
std::int64_t newest_logged_us(const std::filesystem::path& log) {
  const record::EventLogFile file(log);
  record::EventLogReader reader = file.reader();
  std::int64_t newest = 0;
  while (const auto event = reader.next()) newest = std::max(newest, event->utime_us);
  return newest;
}

constexpr std::uint64_t kStepsPerLook = 256;  // for Ctrl-C and orders of the operator
constexpr double kLook_s = 0.2;               // while the print is paused
constexpr const char* kScripted = "firn print";

void print_in_lab(const Product& product, const runs::RunFolder& run, const Experiment& e,
                  const LabRunOptions& options, bool resume, const runs::FolderWatch& folder,
                  LabRunReport& report) {
  const Blobs inputs = run.inputs();
  runs::RunCommit commits(run.path());
  if (resume) {
    // A live world that was killed: its inputs since the last saved state are given again.
    if (std::filesystem::exists(run.world_journal_path()))
      plant::KeptWorld(run.path(), nature_of(e, inputs, options)).close();
  }
  if (!resume) written([&] { commits.commit({}); });
  runs::ResumePoint point;
  PrintJudge judge(product, e, options.tolerance_um);
  if (resume) {
    point = runs::read_resume_point(run.path(), {channels::kRunEnd.name, channels::kLayerMetrics.name});
    if (const auto last = newest<layer_metrics_t>(point, channels::kLayerMetrics.name)) judge.take(*last);
    if (const auto finished = finished_before(point, judge)) {
      runs::repair_from_write_ahead(run.log_path(), run.nodes_path());
      report.result = *finished;
      add_facts(run, e, report.result);
      written([&] { run.write_result(report.result); });
      return;
    }
  }
  const auto record = plant::make_record_file(run.world_record_path());
  PlantWorld world(make_world(run, nature_of(e, inputs, options), resume, record.get()));
  Lab lab(&world);
  std::vector<std::unique_ptr<Member>> members;
  for (const NamedMaker& maker : taking_part(product, e)) {
    members.push_back(std::make_unique<Member>(run, maker, inputs, resume));
    lab.add(&members.back()->host);
  }
  Afterlife after;
  Time begin;
  std::int32_t incarnation = 0;
  if (resume) {
    restore_all(run, members, after);
    incarnation = point.incarnation;
    runs::repair_from_write_ahead(run.log_path(), run.nodes_path());
    begin =
        Time{std::max({point.offset_us, newest_logged_us(run.log_path()) + 1, world.world().now_us() + 1})};
    run.clear_result();
  }

  record::EventLogWriter::Options log_options;
  log_options.mode = resume ? record::File::Mode::kAppend : record::File::Mode::kCreate;
  record::EventLogWriter log(run.log_path(), log_options);
  const auto save = [&](const std::filesystem::path& state) { world.world().save(state); };
  const auto flush = [&] {
    if (const std::string trouble = folder.trouble(); !trouble.empty()) throw Unwritable(trouble);
    record->flush();
    for (const auto& m : members) m->wal.flush();
    log.flush();
  };
  if (resume)
    written([&] {
      flush();
      commits.commit(save);
    });
  std::vector<std::byte> bytes;
  for (const auto& m : members) {
    for (std::int32_t k = m->last_head + 1; k <= incarnation; ++k) {
      const WalHead head = run.wal_head(m->host.name(), k);
      bytes.clear();
      encode_head(head, bytes);
      m->wal.append(WalKind::kHead, bytes);
      log.append(begin.us, channels::config(m->host.id()).name, config_message(head));
    }
  }
  Outbox launcher(NodeId::kLauncher, run.run_id());
  const auto launcher_sends = [&] {
    for (std::size_t n = 0; n < launcher.size(); ++n)
      lab.publish(launcher.at(n).channel, launcher.at(n).bytes);
  };
  const auto note = [&](const std::string& text) {
    options.note ? options.note(text) : void(std::fprintf(stderr, "%s\n", text.c_str()));
  };
  OperatorDesk desk(run.path(), run.run_id(), e, note);
  for (const operator_command_t& m : point.orders) desk.remember(to_order(m));
  run_end_t end{};
  bool truth_due = false;
  std::int32_t measured_layer = 0;
  GridSpec map_grid;
  lab.set_tap([&](std::string_view channel, std::span<const std::byte> bytes, Time now) {
    ++report.messages;
    report.message_bytes += bytes.size();
    if (find_channel(channel)->logged) log.append(std::max(now, begin).us, channel, bytes);
    if (options.warned && channel.starts_with("FAULT_")) {
      fault_t fault{};
      if (fault.decode(bytes.data(), 0, int(bytes.size())) >= 0 &&
          Severity(fault.severity) == Severity::kWarning)
        options.warned(fault);
    }
    if (channel == channels::kSafeStop.name) desk.on_safe_stop();
    if (fault_t m; channel == channels::fault(NodeId::kScheduler).name &&
                   m.decode(bytes.data(), 0, int(bytes.size())) >= 0 &&
                   m.severity == std::int8_t(Severity::kNotice)) {
      note(m.text);
      desk.tell("note " + m.text);
    }
    if (channel == channels::kRunEnd.name) end.decode(bytes.data(), 0, int(bytes.size()));
    if (height_map_t m; prints_paths(e) && channel == channels::kHeightMap.name &&
                        m.decode(bytes.data(), 0, int(bytes.size())) >= 0)
      map_grid = from_message(m.grid);
    if (channel == channels::kLayerMetrics.name) {
      truth_due = true;
      layer_metrics_t m{};
      if (m.decode(bytes.data(), 0, int(bytes.size())) < 0) return;
      measured_layer = report.result.layers = m.layer;
      judge.take(m);
      if (options.progress) options.progress(m);
      desk.tell(m);
    }
  });

  launcher.begin(begin, incarnation);
  run_start_t started{};
  started.name = e.run.name;
  started.commit = build_commit();
  started.scheme = e.control.scheme;
  launcher.send(channels::kRunStart, started);
  launcher_sends();
  after.hand_over(lab, members);
  lab.start(incarnation, begin);
  PausedClock paused(e.run.time_scale);
  const auto obey = [&](const OperatorOrder& order, const std::string& from) {
    launcher.begin(std::max(begin, lab.now()), incarnation);
    launcher.send(channels::kOperatorCommand, to_message(order, from));
    launcher_sends();
    if (from == kScripted) return;
    note("the operator: " + to_text(order));
    order.verb == OperatorVerb::kPause ? paused.begin(lab.now()) : paused.end();
  };
  for (const OperatorOrder& order : options.orders) {
    desk.remember(order);
    obey(order, kScripted);
  }

  const Time limit = begin.after_s(3600.0 * 24 * 30);
  // An instrument that sends nothing more is never reported safe: the wait for safety must end.
  const double patience_s = kSafetyWall_s * e.run.time_scale;
  std::optional<Time> scheduler_done;
  const auto over = [&] {
    bool all = true;
    for (const auto& m : members) {
      const NodeId id = m->host.id();
      if (id == NodeId::kScheduler && m->host.finished() && !scheduler_done) scheduler_done = lab.now();
      if ((id == NodeId::kScheduler || id == NodeId::kSafety) && !m->host.finished()) all = false;
    }
    return all || (scheduler_done && seconds_between(*scheduler_done, lab.now()) > patience_s);
  };
  std::size_t faults_done = 0, orders_done = 0;
  bool interrupted = false;
  const auto asked_to_stop = [&] { return options.interrupted && options.interrupted(); };
  while (!over()) {
    if ((lab.steps() % kStepsPerLook == 0 || paused.running()) && asked_to_stop()) {
      interrupted = true;
      break;
    }
    for (; faults_done < options.faults.size() && lab.now().s() >= options.faults[faults_done].node_s;
         ++faults_done)
      world.inject(options.faults[faults_done].fault, lab.now());
    for (; orders_done < options.later.size() && lab.now().s() >= options.later[orders_done].node_s;
         ++orders_done)
      obey(options.later[orders_done].order, kScripted);
    if (lab.steps() % kStepsPerLook == 0 || paused.running()) desk.service(obey);
    for (double ahead_s; (ahead_s = paused.ahead_s(lab.now())) > 0.0 && !asked_to_stop();) {
      desk.wait(int(std::min(ahead_s, kLook_s) * 1e3) + 1);
      desk.service(obey);
    }
    if (options.crash_after_steps && lab.steps() >= options.crash_after_steps) {
      report.crashed = true;
      break;
    }
    if (!lab.step(limit))
      throw std::runtime_error("the lab stands still at " + std::to_string(lab.now().s()) +
                               " s of node time");
    if (truth_due) {
      truth_due = false;
      plant::Truth t = world.world().truth();
      if (world.world().ice()) t.height = world.world().ice()->height_over(halved(map_grid));
      launcher.begin(lab.now(), incarnation);
      sim_truth_t m{};
      m.layer = prints_paths(e) ? measured_layer : std::int32_t(t.exposures);
      m.droplets_fired = t.droplets_fired;
      m.volume_mm3 = t.volume_mm3;
      m.grid = to_message(t.height.spec);
      m.n = std::int32_t(t.height.size());
      m.height_mm.assign(t.height.cells.begin(), t.height.cells.end());
      const plant::TruthRecord told{lab.now().us, plant::truth_digest(m.layer, m.droplets_fired, m.volume_mm3,
                                                                      t.height.spec, m.height_mm)};
      record->append(plant::RecordKind::kTruth, std::as_bytes(std::span(&told, 1)));
      launcher.send(channels::kSimTruth, m);
      launcher_sends();
      written([&] {
        flush();
        commits.commit(save);
      });
    }
  }
  written([&] {
    flush();
    log.close();
    commits.end(save);
  });

  report.node_seconds = seconds_between(begin, lab.now());
  report.now_us = lab.now().us;
  report.steps = lab.steps();
  report.truth = world.world().truth().height;
  for (const auto& m : members) report.handler_seconds += double(m->host.handler_ns()) * 1e-9;
  if (interrupted)
    report.result = {"interrupted", kInterrupted, report.result.layers, "interrupted by the operator"};
  if (report.crashed) return;
  if (!interrupted) {
    runs::RunResult result = runs::result_of(end.outcome, end.layers, end.reason);
    judge.judge(result);
    result.reason += validity_words(world.world().truth().validity);
    add_facts(run, e, result);
    written([&] { run.write_result(result); });
    report.result = result;
  }
  desk.tell("end " + std::to_string(report.result.status) + " " + report.result.outcome);
}

}  // namespace

LabRunReport run_in_lab(const Product& product, const runs::RunFolder& run, const LabRunOptions& options) {
  const Experiment e = parse_experiment(run.experiment_toml(), run.experiment_path().string());
  LabRunReport report;
  std::string cause;
  const runs::FolderWatch folder(run.path());
  std::optional<runs::RunLock> held;
  try {
    if (!options.lock) held.emplace(run.path(), runs::RunUse::kPrint);
    const runs::LabLock lock(run, e, {}, runs::LabLock::Heirs::kNobody);
    const bool resume = options.resume && runs::ready_to_resume(run.path());
    runs::SealedIncarnation seal(run.path(), run.run_id(), resume, options.unsealed);
    print_in_lab(product, run, e, options, resume, folder, report);
    if (!report.crashed) seal.ended(report.result);
  } catch (const Unwritable& error) {
    cause = error.what();
  } catch (const plant::NatureError& error) {
    cause = error.what();
  } catch (const std::exception& error) {
    cause = runs::storage_trouble(error);
    if (cause.empty()) throw;
  }
  report.folder = folder.now();
  if (cause.empty()) return report;
  if (const std::string moved = folder.trouble(); !moved.empty()) cause = moved;
  report.result = {"stopped safely", kSafetyStop, report.result.layers, cause};
  try {  // the files are closed; what fails here the resume does again
    if (!report.folder.empty()) runs::roll_back(report.folder);
  } catch (const std::exception&) {
  }
  return report;
}

}  // namespace firn
