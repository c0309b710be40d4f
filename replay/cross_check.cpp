#include "replay/cross_check.h"

#include <algorithm>

#include "runs/read/bytes.h"
#include "runs/read/describe.h"

namespace firn::replay {

SentIndex::SentIndex(const std::vector<NodeOutcome>& nodes)
    : nodes_(nodes), publishers_(runs::ChannelIndex::size()) {
  for (const NodeOutcome& node : nodes)
    if (node.replayed)
      for (std::size_t n = 0; n < publishers_.size(); ++n) {
        const ChannelInfo& channel = channel_table()[n];
        if (runs::sent_by_node(channel) && info(channel.publisher).name == node.verdict.name)
          publishers_[n] = &node;
      }
}

const std::deque<Sent>& SentIndex::all(int channel) const {
  static const std::deque<Sent> none;
  const NodeOutcome* node = publishers_[std::size_t(channel)];
  return node ? node->sent[std::size_t(channel)] : none;
}

// Sequence numbers count from 1 without gaps, unless the file is damaged.
std::optional<std::size_t> SentIndex::position(int channel, std::int64_t seq) const {
  const std::deque<Sent>& list = all(channel);
  if (seq >= 1 && seq <= std::int64_t(list.size()) && list[std::size_t(seq - 1)].seq == seq)
    return std::size_t(seq - 1);
  const auto it = std::ranges::find(list, seq, &Sent::seq);
  if (it == list.end()) return std::nullopt;
  return std::size_t(it - list.begin());
}

const Sent* SentIndex::find(int channel, std::int64_t seq) const {
  const std::optional<std::size_t> at = position(channel, seq);
  return at ? &all(channel)[*at] : nullptr;
}

std::uint64_t SentIndex::step_after(int channel, std::int64_t seq) const {
  for (const Sent& s : all(channel))
    if (s.seq > seq) return s.step;
  return publishers_[std::size_t(channel)]->verdict.steps;
}

void SentIndex::read(std::size_t bytes) const {
  constexpr std::size_t kHeld_bytes = std::size_t(32) << 20;
  held_ += bytes;
  if (held_ < kHeld_bytes) return;
  for (const NodeOutcome& node : nodes_)
    if (node.file) node.file->forget();
  held_ = 0;
}

namespace {

// A message absent from a file was lost at the time of sending, not at the time of the next message.
void tell_gaps(const SentIndex& sent, NodeOutcome& node) {
  for (Gap& gap : node.gaps) {
    if (const Sent* s = sent.find(gap.channel, gap.from)) gap.finding.at = s->at;
    node.add(std::move(gap.finding));
  }
}

void check_delivery(const SentIndex& sent, NodeOutcome& node, const Delivered& d, MessageComparer& comparer) {
  const ChannelInfo& channel = channel_table()[std::size_t(d.channel)];
  const Sent* s = sent.find(d.channel, d.seq);
  if (s && (s->differs || runs::same_bytes(s->bytes, d.bytes))) return;
  const std::string publisher(info(channel.publisher).name);
  Finding f;
  f.kind = FindingKind::kDelivery;
  f.node = node.verdict.name;
  f.step = d.step;
  f.at = d.at;
  f.channel = channel.name;
  f.seq = d.seq;
  if (!s) {
    f.kind = FindingKind::kMissing;
    f.node = publisher;
    f.step = sent.step_after(d.channel, d.seq);
    f.what = "the file lacks what led to this message before this step; " + node.verdict.name +
             " was given it in its step " + std::to_string(d.step);
  } else {
    const auto difference = comparer.compare(channel, s->bytes, d.bytes);
    if (!difference) return;
    f.what = "delivered bytes differ from what " + publisher + " sent in its step " + std::to_string(s->step);
    f.field = difference->path;
    f.recorded = difference->a;
    f.replayed = difference->b;
    Event event;
    event.kind = EventKind::kMessage;
    event.now = d.at;
    event.channel = channel.name;
    event.bytes = d.bytes;
    if (node.findings.size() < RunVerdict::kKeptWithInputs)
      f.inputs.push_back(runs::as_json(d.step, event, {}));
  }
  node.add(std::move(f));
}

}  // namespace

void check_deliveries(const SentIndex& sent, std::vector<NodeOutcome>& nodes, MessageComparer& comparer) {
  for (NodeOutcome& node : nodes) {
    tell_gaps(sent, node);
    for (const Delivered& d : node.delivered) {
      if (sent.knows(d.channel)) check_delivery(sent, node, d, comparer);
      sent.read(2 * d.bytes.size());
    }
  }
}

}  // namespace firn::replay
