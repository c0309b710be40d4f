#include <catch2/catch.hpp>

#include <fstream>
#include <sstream>

#include "cli/dataflow_command.h"
#include "lcmtypes/channels.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"

using namespace firn;

TEST_CASE("docs/dataflow.md is what `firn dataflow` writes") {
  std::ifstream in(std::string(FIRN_SOURCE_DIR) + "/docs/dataflow.md");
  std::stringstream committed;
  committed << in.rdbuf();
  const bool same = committed.str() == dataflow_markdown(full_product());
  INFO("write it again with: ./firn dataflow");
  CHECK(same);
}

TEST_CASE("Every node subscribes only to channels of the table that nodes may read") {
  for (const auto& [channel, subscribers] : all_subscriptions(full_product())) {
    INFO(channel);
    const ChannelInfo* info = find_channel(channel);
    REQUIRE(info);
    CHECK(info->nodes_may_read);
  }
}

TEST_CASE("What a node reads only with some settings is in the table too") {
  const Subscriptions all = all_subscriptions(full_product());
  for (const char* channel : {"DEPOSITION_REPORT", "FLOW_MODEL", "HEIGHT_MODEL"}) {
    INFO(channel);
    REQUIRE(all.contains(channel));
    CHECK(all.at(channel).contains("controller"));
  }
}

TEST_CASE("The document names every channel or its family and every node") {
  const std::string text = dataflow_markdown(full_product());
  for (const NodeInfo& n : nodes()) CHECK(text.find(std::string(n.name)) != std::string::npos);
  for (const ChannelInfo& c : channel_table()) CHECK(text.find(std::string(c.type)) != std::string::npos);
}
