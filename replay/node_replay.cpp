#include "replay/node_replay.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>

#include "files/digest.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "replay/decision_compare.h"
#include "runs/folder/origin.h"
#include "runs/read/bytes.h"
#include "runs/read/describe.h"
#include "runtime/node_host.h"

namespace firn::replay {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kInputsTold = 4;

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

Blobs load_blobs(const fs::path& run, const WalHead& head) {
  Blobs blobs;
  for (const auto& [role, sha256] : head.blobs) {
    if (!is_sha256_hex(sha256))
      throw std::runtime_error("input '" + role + "': '" + sha256.substr(0, 100) +
                               "' is no SHA-256, 64 hexadecimal digits");
    const RunPaths paths(run);
    const fs::path path = paths.input_path(sha256);
    const std::string name = path.lexically_relative(run).string();
    std::error_code unreadable;  // a link to itself: opening it names it
    if (fs::symlink_status(path, unreadable).type() == fs::file_type::not_found)
      throw std::runtime_error("input '" + role + "' is missing: " + name);
    const record::MappedFile file(path, record::MappedFile::Packed::kAsIs);
    if (sha256_hex(file.bytes()) != sha256)
      throw std::runtime_error("input '" + role + "' was changed: " + name +
                               " does not have the SHA-256 of its name");
    blobs.push_back({role, sha256, {file.bytes().begin(), file.bytes().end()}});
  }
  return blobs;
}

class NodeReplay {
 public:
  NodeReplay(const fs::path& run, const NodeMaker& maker, const runs::ChannelIndex& channels,
             const runs::RunMigration& migration, const ReplayOptions& options)
      : run_(run),
        maker_(maker),
        channels_(channels),
        options_(options),
        comparer_(options),
        migration_(migration, maker.name, out_.migrated),
        last_(channels.size()) {
    out_.verdict.name = maker.name;
    out_.sent.assign(channels.size(), SentList(*out_.sent_blocks));
  }

  NodeOutcome go() {
    try {
      out_.file = std::make_unique<runs::WalFile>(run_ / file_name());
      read();
      note_damage();
    } catch (const std::exception& e) {
      tell(FindingKind::kUnreadable, e.what());
    }
    out_.ignored = comparer_.ignored();
    out_.largest_difference = comparer_.largest_difference();
    out_.largest_difference_field = comparer_.largest_difference_field();
    return std::move(out_);
  }

 private:
  struct Last {
    std::int64_t seq = 0;
    std::int32_t incarnation = 0;
  };

  std::string file_name() const { return RunPaths::wal_name(maker_.name); }

  void read() {
    for (;;) switch (out_.file->next()) {
        case runs::WalFile::Item::kEnd:
          if (!out_.head)
            tell(FindingKind::kUnreadable, file_name() + " holds no head, so the node cannot be built");
          return;
        case runs::WalFile::Item::kHead:
          if (!open_incarnation(out_.file->head())) return;
          break;
        case runs::WalFile::Item::kStep:
          if (!host_) {
            tell(FindingKind::kUnreadable,
                 "byte " + std::to_string(out_.file->offset()) + " of " + file_name() +
                     ": an event stands where the head must be, so the node cannot be built");
            return;
          }
          if (!step(out_.file->step())) return;
          break;
        case runs::WalFile::Item::kStray:
          stray(out_.file->step());
          break;
        case runs::WalFile::Item::kUnknown:
          tell(FindingKind::kMissing, "byte " + std::to_string(out_.file->offset()) + " of " + file_name() +
                                          ": " + out_.file->trouble());
          break;
      }
  }

  bool open_incarnation(const WalHead& head) {
    ++out_.verdict.incarnations;
    started_ = false;
    if (head.node != maker_.name) {
      tell(FindingKind::kForeign, file_name() + " is a file of node " + head.node);
      return false;
    }
    note_provenance("commit", head.commit, options_.commit);
    note_provenance("platform", head.platform, options_.platform);
    if (out_.head) {
      if (head.run_id != out_.head->run_id) {
        tell(FindingKind::kForeign, "a later head of " + file_name() + " is of run " +
                                        std::to_string(head.run_id) + ", the first one of run " +
                                        std::to_string(out_.head->run_id));
        return false;
      }
      if (head.incarnation <= incarnation_)
        tell(FindingKind::kOrder, "incarnation " + std::to_string(head.incarnation) +
                                      " begins after incarnation " + std::to_string(incarnation_));
      if (head.config_toml != out_.head->config_toml || head.blobs != out_.head->blobs)
        tell(FindingKind::kForeign,
             "incarnation " + std::to_string(head.incarnation) +
                 " was started with another configuration or other inputs than the first one");
      incarnation_ = head.incarnation;
      return true;
    }
    out_.head = head;
    incarnation_ = head.incarnation;
    const std::string config =
        options_.change_config ? options_.change_config(head.config_toml) : head.config_toml;
    if (!may_run(head, config)) return false;
    host_.emplace(find_node(maker_.name)->id, maker_.make(config, load_blobs(run_, head)), head.run_id,
                  nullptr);
    ports_ = host_->ports();
    out_.replayed = true;
    return true;
  }

  // Code comes from the recorded inputs alone: a setting that was changed since chooses among them.
  bool may_run(const WalHead& head, const std::string& config) {
    const std::string python = runs::python_of(config, std::string(maker_.name));
    const bool own = python.empty() || (options_.run_python == RunPython::kOwn &&
                                        runs::is_own_run(run_, head.run_id, head.config_toml, head.blobs));
    if (own || options_.run_python == RunPython::kAlways) return true;
    out_.verdict.python = python;
    return false;
  }

  void note_provenance(const char* what, const std::string& recorded, const std::string& here) {
    if (!here.empty() && recorded != here)
      out_.provenance.push_back(std::string(what) + ": recorded with " + recorded + ", replayed with " +
                                here);
  }

  // @returns false when the node cannot go on.
  bool step(const runs::RecordedStep& recorded) {
    now_ = recorded;
    now_.event = migration_.event(recorded.event);
    const runs::RecordedStep& s = now_;
    const Event& e = s.event;
    current_ = &s;
    recent_[out_.verdict.steps++ % recent_.size()] = s;
    if (s.damaged_at) damaged_steps_.emplace_back(*s.damaged_at, s.step);
    check_place(s);
    if (e.kind == EventKind::kWake) check_timer(e);
    if (e.kind == EventKind::kMessage) check_delivery(s);

    const std::int64_t began = options_.stopwatch ? now_ns() : 0;
    const Outbox* outbox = nullptr;
    try {
      outbox = &host_->replay_step(e);
    } catch (const std::exception& error) {
      const std::string why =
          "step " + std::to_string(s.step) + ", " + runs::place_of(e, ports_) + ": " + error.what();
      if (s.last && !s.has_outputs)
        out_.verdict.crash = why;
      else
        tell(FindingKind::kCrash, "the handler throws, in the run it did not: " + std::string(error.what()) +
                                      "; the node's later steps were not replayed");
      return false;
    }
    if (options_.stopwatch) out_.verdict.handler_ns += now_ns() - began;
    out_.verdict.recorded_handler_ns += s.handler_ns;
    compare(s, *outbox);
    return true;
  }

  void check_place(const runs::RecordedStep& s) {
    const Event& e = s.event;
    if (s.step > next_step_)
      tell(FindingKind::kMissing, s.step == next_step_ + 1
                                      ? "the event of step " + std::to_string(next_step_) + " is missing"
                                      : "the events of steps " + std::to_string(next_step_) + " to " +
                                            std::to_string(s.step - 1) + " are missing");
    if (s.step < next_step_)
      tell(FindingKind::kOrder,
           "step " + std::to_string(s.step) + " stands behind step " + std::to_string(next_step_ - 1));
    next_step_ = s.step + 1;
    if (e.now.us < out_.verdict.last_us)
      tell(FindingKind::kOrder, "time goes back from " + std::to_string(out_.verdict.last_us) + " us to " +
                                    std::to_string(e.now.us) + " us");
    out_.verdict.last_us = std::max(out_.verdict.last_us, e.now.us);
    if (!started_ && e.kind != EventKind::kStart)
      tell(FindingKind::kMissing,
           "the start event of incarnation " + std::to_string(incarnation_) + " is missing");
    if (e.kind == EventKind::kStart && (started_ || e.incarnation != incarnation_))
      tell(FindingKind::kOrder, "a start event of incarnation " + std::to_string(e.incarnation) +
                                    " stands in incarnation " + std::to_string(incarnation_));
    started_ = true;
  }

  void check_timer(const Event& e) {
    if (!host_->is_armed(TimerId(e.id), e.due))
      tell(FindingKind::kTimer, "the node did not ask to be woken at " + std::to_string(e.due.us) + " us");
    else if (e.due > e.now)
      tell(FindingKind::kTimer,
           "woken at " + std::to_string(e.now.us) + " us, before " + std::to_string(e.due.us) + " us");
  }

  void check_delivery(const runs::RecordedStep& s) {
    const Event& e = s.event;
    if (e.channel == runs::NodeMigration::kNotGiven) return;
    ++out_.verdict.events_in;
    const int number = channels_.find(e.channel);
    if (number < 0 || !host_->subscribes(e.channel)) {
      tell(FindingKind::kForeign, "a message on a channel that the node does not read");
      return;
    }
    const std::optional<runs::Stamp> stamp = runs::stamp_of(e.bytes);
    if (!stamp) {
      tell(FindingKind::kForeign, "a message too short to hold a header");
      return;
    }
    if (stamp->run_id != out_.head->run_id)
      tell(FindingKind::kForeign, "a message of run " + std::to_string(stamp->run_id) + ", the run is " +
                                      std::to_string(out_.head->run_id));
    const ChannelInfo& channel = channel_table()[std::size_t(number)];
    Last& last = last_[std::size_t(number)];
    const bool restarted = stamp->incarnation > last.incarnation && !runs::sent_by_node(channel);
    if (channel.delivery == Delivery::kReliable && !restarted) {
      if (stamp->seq > last.seq + 1) keep_gap(number, last.seq + 1, stamp->seq - 1);
      if (stamp->seq <= last.seq)
        tell(FindingKind::kOrder, range(channel.name, stamp->seq, stamp->seq) + " was delivered after " +
                                      std::to_string(last.seq));
    } else if (!restarted && stamp->seq <= last.seq) {
      tell(FindingKind::kOrder, "stale: " + range(channel.name, stamp->seq, stamp->seq) +
                                    " was delivered after " + std::to_string(last.seq));
    }
    last = {stamp->seq, stamp->incarnation};
    if (runs::sent_by_node(channel)) out_.delivered.push_back({number, stamp->seq, e.bytes, s.step, e.now});
  }

  void keep_gap(int channel, std::int64_t from, std::int64_t to) {
    if (out_.gaps.size() == RunVerdict::kKeptPerNode) {
      ++out_.more_gaps;
      return;
    }
    const std::string what = "the delivery of " +
                             range(channel_table()[std::size_t(channel)].name, from, to) +
                             " is missing before this step";
    out_.gaps.push_back({channel, from, to, finding(FindingKind::kMissing, what)});
  }

  static std::string range(std::string_view channel, std::int64_t from, std::int64_t to) {
    return std::string(channel) + " " + std::to_string(from) + (to > from ? " to " + std::to_string(to) : "");
  }

  void compare(const runs::RecordedStep& s, const Outbox& replayed) {
    recorded_.clear();
    if (s.has_outputs) {
      try {
        decode_output_list(s.outputs, recorded_);
      } catch (const std::runtime_error& e) {
        tell(FindingKind::kMissing, std::string("the recorded outputs do not decode: ") + e.what());
        return;
      }
      migration_.outputs(recorded_);
    } else if (s.last && !replayed.empty()) {
      keep_cut(s, replayed);
      return;
    }
    bool told = false;
    for (std::size_t n = 0; n < std::max(recorded_.size(), replayed.size()); ++n) {
      const std::optional<Output> a = n < recorded_.size() ? std::optional(recorded_[n]) : std::nullopt;
      const std::optional<Output> b = n < replayed.size() ? std::optional(replayed.at(n)) : std::nullopt;
      if (a && a->kind == OutputKind::kSend) count_decision(*a, b);
      const bool differs = !same(a, b) && tell_output(n, a, b, told);
      told |= differs;
      if (a) keep(s, *a, differs);
    }
    out_.verdict.differing_steps += told;
  }

  void count_decision(const Output& a, const std::optional<Output>& b) {
    const bool has_both = b && b->kind == OutputKind::kSend && b->channel == a.channel;
    const auto cells =
        differing_cells(a.channel, a.bytes, has_both ? b->bytes : std::span<const std::byte>{});
    out_.verdict.decisions += cells.has_value();
    out_.verdict.differing_decisions += cells.value_or(0) > 0;
    out_.verdict.differing_cells += cells.value_or(0);
  }

  static bool same(const std::optional<Output>& a, const std::optional<Output>& b) {
    return a && b && a->kind == b->kind && a->channel == b->channel && a->id == b->id && a->at == b->at &&
           runs::same_bytes(a->bytes, b->bytes);
  }

  // Reports the first difference of a step. @returns false if tolerance and ignored fields make the outputs
  // equal.
  bool tell_output(std::size_t n, const std::optional<Output>& a, const std::optional<Output>& b, bool told) {
    FieldDifference difference;
    const bool same_place = a && b && a->kind == b->kind && a->channel == b->channel && a->id == b->id;
    if (same_place && a->kind == OutputKind::kSend) {
      const auto found = comparer_.compare(*find_channel(a->channel), a->bytes, b->bytes);
      if (!found) return false;
      difference = *found;
    } else if (same_place && a->kind == OutputKind::kArm) {
      difference = {"at_us", std::to_string(a->at.us), std::to_string(b->at.us), 0};
    } else if (same_place) {
      difference = byte_difference(a->bytes, b->bytes);
    } else {
      difference = {"output " + std::to_string(n), a ? runs::in_words(*a) : "nothing",
                    b ? runs::in_words(*b) : "nothing", 0};
    }
    if (told) return true;
    Finding f = finding(FindingKind::kOutput, "the node puts out something else than was recorded");
    const Output& shown = a ? *a : *b;
    f.channel = runs::place_of(shown, ports_);
    if (shown.kind == OutputKind::kSend)
      if (const auto stamp = runs::stamp_of(shown.bytes)) f.seq = stamp->seq;
    f.field = difference.path;
    f.recorded = difference.a;
    f.replayed = difference.b;
    out_.add(std::move(f));
    return true;
  }

  void keep(const runs::RecordedStep& s, const Output& o, bool differs) {
    out_.verdict.bytes += o.bytes.size();
    if (o.kind != OutputKind::kSend) return;
    ++out_.verdict.messages;
    const int number = channels_.find(o.channel);
    const std::optional<runs::Stamp> stamp = runs::stamp_of(o.bytes);
    if (number >= 0 && stamp && info(channel_table()[std::size_t(number)].publisher).name == maker_.name)
      out_.sent[std::size_t(number)].push_back({stamp->seq, o.bytes, s.step, s.event.now, false, differs});
  }

  // A kill fell between the event's record and the outputs': after a resume they may still have gone out.
  void keep_cut(const runs::RecordedStep& s, const Outbox& replayed) {
    ++out_.verdict.cut;
    for (std::size_t n = 0; n < replayed.size(); ++n) {
      const Output o = replayed.at(n);
      if (o.kind != OutputKind::kSend) continue;
      const auto& bytes = out_.cut_bytes.emplace_back(o.bytes.begin(), o.bytes.end());
      const std::optional<runs::Stamp> stamp = runs::stamp_of(bytes);
      out_.sent[std::size_t(channels_.find(o.channel))].push_back(
          {stamp->seq, bytes, s.step, s.event.now, true, false});
    }
  }

  void stray(const runs::RecordedStep& s) {
    current_ = nullptr;
    Finding f = finding(FindingKind::kMissing, "outputs of step " + std::to_string(s.step) +
                                                   " stand without their event, byte " +
                                                   std::to_string(s.offset) + " of " + file_name());
    f.step = s.step;
    f.at = Time{out_.verdict.last_us};
    out_.add(std::move(f));
  }

  Finding finding(FindingKind kind, std::string what) {
    Finding f;
    f.kind = kind;
    f.node = maker_.name;
    f.what = std::move(what);
    f.at = Time{out_.verdict.last_us};
    if (!current_) return f;
    f.step = current_->step;
    f.at = current_->event.now;
    f.channel = runs::place_of(current_->event, ports_);
    if (current_->event.kind == EventKind::kMessage)
      if (const auto stamp = runs::stamp_of(current_->event.bytes)) f.seq = stamp->seq;
    if (out_.findings.size() >= RunVerdict::kKeptWithInputs) return f;
    const std::uint64_t steps = out_.verdict.steps;
    for (std::uint64_t n = steps - std::min<std::uint64_t>(steps, recent_.size()); n < steps; ++n)
      f.inputs.push_back(
          runs::as_json(recent_[n % recent_.size()].step, recent_[n % recent_.size()].event, ports_));
    return f;
  }

  void tell(FindingKind kind, std::string what) { out_.add(finding(kind, std::move(what))); }

  void note_damage() {
    for (const record::Damage& d : out_.file->damage().list()) {
      DamagedPlace place{file_name(), d.offset, d.bytes, std::string(d.reason), {}};
      for (const auto& [offset, step] : damaged_steps_)
        if (offset == d.offset) place.step = step;
      out_.damage.push_back(std::move(place));
    }
  }

  const fs::path& run_;
  const NodeMaker& maker_;
  const runs::ChannelIndex& channels_;
  const ReplayOptions& options_;
  MessageComparer comparer_;
  NodeOutcome out_;
  runs::NodeMigration migration_;
  std::optional<NodeHost> host_;
  std::vector<std::string> ports_;
  std::vector<Last> last_;        // by ChannelIndex
  std::vector<Output> recorded_;  // of the step; storage used again
  runs::RecordedStep now_;        // as delivered to today's node
  std::array<runs::RecordedStep, kInputsTold> recent_;
  const runs::RecordedStep* current_ = nullptr;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> damaged_steps_;  // byte, step
  std::uint64_t next_step_ = 0;
  std::int32_t incarnation_ = 0;
  bool started_ = false;
};

}  // namespace

void SentList::push_back(const Sent& sent) {
  ascending_ = ascending_ && sent.seq > last_;
  last_ = sent.seq;
  list_.push_back(sent);
}

// Sequence numbers count from 1 without gaps, unless the file is damaged.
std::optional<std::size_t> SentList::position(std::int64_t seq) const {
  if (seq >= 1 && seq <= std::int64_t(size()) && list_[std::size_t(seq - 1)].seq == seq)
    return std::size_t(seq - 1);
  if (!ascending_) {
    for (std::size_t n = 0; n < size(); ++n)
      if (list_[n].seq == seq) return n;
    return std::nullopt;
  }
  const std::size_t n = seq > std::numeric_limits<std::int64_t>::min() ? after(seq - 1) : 0;
  return n < size() && list_[n].seq == seq ? std::optional(n) : std::nullopt;
}

std::size_t SentList::after(std::int64_t seq) const {
  if (ascending_) return list_.partition_point([&](const Sent& s) { return s.seq <= seq; });
  std::size_t n = 0;
  while (n < size() && list_[n].seq <= seq) ++n;
  return n;
}

void NodeOutcome::add(Finding finding) {
  ++findings_total;
  if (findings.size() < RunVerdict::kKeptPerNode) findings.push_back(std::move(finding));
}

NodeOutcome replay_node(const std::filesystem::path& run, const NodeMaker& maker,
                        const runs::ChannelIndex& channels, const runs::RunMigration& migration,
                        const ReplayOptions& options) {
  return NodeReplay(run, maker, channels, migration, options).go();
}

}  // namespace firn::replay
