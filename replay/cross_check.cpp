#include "replay/cross_check.h"

#include "runs/read/bytes.h"
#include "runs/read/describe.h"

namespace firn::replay {

SentIndex::SentIndex(const std::vector<NodeOutcome>& nodes) : publishers_(runs::ChannelIndex::size()) {
  for (const NodeOutcome& node : nodes)
    if (node.replayed)
      for (std::size_t n = 0; n < publishers_.size(); ++n) {
        const ChannelInfo& channel = channel_table()[n];
        if (runs::sent_by_node(channel) && info(channel.publisher).name == node.verdict.name)
          publishers_[n] = &node;
      }
}

const SentList* SentIndex::all(int channel) const {
  const NodeOutcome* node = publishers_[std::size_t(channel)];
  return node ? &node->sent[std::size_t(channel)] : nullptr;
}

std::optional<std::size_t> SentIndex::position(int channel, std::int64_t seq) const {
  const SentList* list = all(channel);
  return list ? list->position(seq) : std::nullopt;
}

const Sent* SentIndex::find(int channel, std::int64_t seq) const {
  const std::optional<std::size_t> at = position(channel, seq);
  return at ? &at_place(channel, *at) : nullptr;
}

const Sent& SentIndex::at_place(int channel, std::size_t place) const {
  const Sent& sent = (*all(channel))[place];
  publishers_[std::size_t(channel)]->file->read_again(sent.bytes);
  return sent;
}

std::uint64_t SentIndex::step_after(int channel, std::int64_t seq) const {
  const SentList& list = *all(channel);
  const std::size_t n = list.after(seq);
  return n < list.size() ? list[n].step : publishers_[std::size_t(channel)]->verdict.steps;
}

namespace {

// A message absent from a file was lost at the time of sending, not at the time of the next message.
void tell_gaps(const SentIndex& sent, NodeOutcome& node) {
  for (Gap& gap : node.gaps) {
    if (const Sent* s = sent.find(gap.channel, gap.from)) gap.finding.at = s->at;
    node.add(std::move(gap.finding));
  }
  node.findings_total += node.more_gaps;
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
    for (std::size_t n = 0; n < node.delivered.size(); ++n) {
      const Delivered& d = node.delivered[n];
      if (sent.knows(d.channel)) check_delivery(sent, node, d, comparer);
      node.file->read_again(d.bytes);
    }
  }
}

}  // namespace firn::replay
