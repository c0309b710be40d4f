#include "cli/dataflow_command.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "cli/commands.h"
#include "cli/generated_document.h"
#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/lowercase.h"
#include "lcmtypes/channels.h"
#include "print/folder/taking_part.h"

namespace firn {
namespace {

/// FAULT_STAGE, FAULT_JET, … are drawn and listed once, as FAULT_*; "" for a channel of its own.
std::string family(const ChannelInfo& channel) {
  const std::string suffix = "_" + std::string(info(channel.publisher).name);
  return lowercase(channel.name).ends_with(suffix)
             ? std::string(channel.name.substr(0, channel.name.size() - suffix.size())) + "_*"
             : "";
}

struct Row {
  std::string name;
  const ChannelInfo* channel = nullptr;
  std::vector<std::string> publishers;
  std::set<std::string> subscribers;
  std::set<std::pair<std::string, std::string>> arrows;  ///< publisher, subscriber
};

std::vector<Row> rows(const Product& product) {
  const Subscriptions subscriptions = all_subscriptions(product);
  std::vector<Row> out;
  for (const ChannelInfo& channel : channel_table()) {
    std::string name = family(channel);
    if (name.empty()) name = channel.name;
    auto row = std::find_if(out.begin(), out.end(), [&](const Row& r) { return r.name == name; });
    if (row == out.end()) row = out.insert(out.end(), Row{name, &channel, {}, {}, {}});
    row->publishers.emplace_back(info(channel.publisher).name);
    const auto found = subscriptions.find(std::string(channel.name));
    if (found == subscriptions.end()) continue;
    for (const std::string& subscriber : found->second) {
      row->subscribers.insert(subscriber);
      row->arrows.emplace(row->publishers.back(), subscriber);
    }
  }
  return out;
}

std::string joined(const auto& words, const char* separator) {
  std::string out;
  for (const std::string& w : words) out += (out.empty() ? "" : separator) + w;
  return out;
}

// Reliable channels have no limit of their queue, the latest message has a queue of one: only others say
// theirs.
std::string delivery_text(const ChannelInfo& channel) {
  const bool reliable = channel.delivery == Delivery::kReliable;
  std::string out = reliable ? "reliable" : "latest";
  if (channel.queue != (reliable ? 0 : 1)) out += ", queue " + std::to_string(channel.queue);
  if (channel.rate_hz != 0.0) out += ", " + std::to_string(int(channel.rate_hz)) + " Hz";
  return out + (channel.logged ? "" : ", not logged");
}

/// Arrows of equal label and source become one, and then those of equal label and target.
struct Arrow {
  std::string from, to, label;
};
void join_arrows(std::vector<Arrow>& arrows, std::string Arrow::*kept, std::string Arrow::*joined) {
  std::vector<Arrow> out;
  for (const Arrow& a : arrows) {
    const auto same = std::find_if(out.begin(), out.end(),
                                   [&](const Arrow& b) { return b.label == a.label && b.*kept == a.*kept; });
    if (same == out.end())
      out.push_back(a);
    else
      (*same).*joined += " & " + a.*joined;
  }
  arrows = out;
}

// One arrow per pair of processes, labelled with the channels, so that the graph stays legible.
std::string graph(const std::vector<Row>& table) {
  std::vector<std::pair<std::string, std::vector<std::string>>> arrows;
  const auto add = [&](const std::string& arrow, const std::string& label) {
    auto a = std::find_if(arrows.begin(), arrows.end(), [&](const auto& x) { return x.first == arrow; });
    if (a == arrows.end()) a = arrows.insert(arrows.end(), {arrow, {}});
    a->second.push_back(label);
  };
  for (const Row& row : table) {
    const bool all = row.publishers.size() == std::size_t(kNodeCount);
    for (const std::string& to : row.subscribers)
      if (all) add("processes|" + to, row.name);
    for (const auto& [from, to] : row.arrows)
      if (!all) add(from + "|" + to, row.name);
  }
  std::string out = "```mermaid\nflowchart LR\n  processes([every process])\n";
  for (const NodeInfo& n : nodes())
    if (n.driver)  // the others are drawn by their arrows
      out += "  " + std::string(n.name) + "[[" + std::string(n.name) + "]]\n";
  std::vector<Arrow> drawn;
  for (const auto& [arrow, labels] : arrows) {
    const std::size_t bar = arrow.find('|');
    drawn.push_back({arrow.substr(0, bar), arrow.substr(bar + 1), joined(labels, "<br/>")});
  }
  join_arrows(drawn, &Arrow::from, &Arrow::to);
  join_arrows(drawn, &Arrow::to, &Arrow::from);
  for (const Arrow& a : drawn) out += "  " + a.from + " -->|" + a.label + "| " + a.to + "\n";
  return out + "```\n";
}

}  // namespace

std::string dataflow_markdown(const Product& product) {
  const std::vector<Row> table = rows(product);
  std::string out =
      "# Data flow\n\n"
      "Written by `firn dataflow` from `lcmtypes/channels.table` and the nodes' subscriptions. Each node is "
      "a\n"
      "process; `[[drivers]]` speak to one instrument each. Channels are reliable, `latest` ones deliver "
      "the\n"
      "newest message. The recorder takes every channel that is logged. Meanings:\n"
      "[channels.table](../lcmtypes/channels.table).\n\n";
  out += graph(table);
  out += "\n";
  for (const Row& r : table) {
    const std::string delivery = delivery_text(*r.channel);
    out += r.name + " " + std::string(r.channel->type) +
           (delivery == "reliable" ? "" : " (" + delivery + ")") + (&r == &table.back() ? ".\n" : ",\n");
  }
  return out;
}

int run_dataflow(const Product& product, const DataflowOptions& options) {
  if (!options.json) {
    write_generated(options.output, dataflow_markdown(product), false);
    return kOk;
  }
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Row& r : rows(product))
    out.push_back({{"channel", r.name},
                   {"type", r.channel->type},
                   {"publishers", r.publishers},
                   {"subscribers", r.subscribers},
                   {"delivery", r.channel->delivery == Delivery::kReliable ? "reliable" : "latest"},
                   {"rate_hz", r.channel->rate_hz},
                   {"queue", r.channel->queue},
                   {"logged", r.channel->logged},
                   {"meaning", r.channel->meaning}});
  std::fputs((out.dump(2) + "\n").c_str(), stdout);
  return kOk;
}

void declare_dataflow(OptionSet& options) {
  auto& o = options.calls(run_dataflow);
  options.option("-o,--output", o.output, "file; - = stdout").show_default();
  options.json_flag(o.json);
}

}  // namespace firn
