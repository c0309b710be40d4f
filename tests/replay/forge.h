// Rewrites the messages and the world's record of a run as if it had gone otherwise: all copies of a message
// alike, with right checksums.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "plant/record/record.h"
#include "runs/migrate/run_migration.h"
#include "runtime/outbox.h"

namespace firn::test {

/// Handles the bytes of one message; false: the message vanishes.
using EditBytes = std::function<bool(std::vector<std::byte>&)>;

/// Edits every copy of every message of a channel, where it was sent and where it was received.
void edit_messages(const std::filesystem::path& run, std::string_view channel, const EditBytes& edit);

template <class Message>
void edit_messages(const std::filesystem::path& run, std::string_view channel,
                   const std::function<bool(Message&)>& edit) {
  edit_messages(run, channel, EditBytes([&](std::vector<std::byte>& bytes) {
                  Message m{};
                  if (!runs::decode_recorded(bytes, m)) return true;
                  if (!edit(m)) return false;
                  bytes.resize(std::size_t(m.getEncodedSize()));
                  m.encode(bytes.data(), 0, int(bytes.size()));
                  return true;
                }));
}

/// Appends what `sent` holds to a node's file, as outputs of one more step.
void add_messages(const std::filesystem::path& run, std::string_view node, const Outbox& sent);

/// Edits the world's own record. Its records are written by kind, each in the order of the lists.
void edit_world(const std::filesystem::path& run, const std::function<void(plant::WorldHistory&)>& edit);

}  // namespace firn::test
