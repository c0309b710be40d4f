// WalFile reads one node's write-ahead file: heads, and steps with the outputs that were recorded for them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "files/record/file.h"
#include "files/record/record_file.h"
#include "runtime/write_ahead.h"

namespace firn::runs {

struct RecordedStep {
  std::uint64_t step = 0;
  Event event;                         ///< views into the file
  bool has_outputs = false;            ///< false: the step had no outputs
  std::span<const std::byte> outputs;  ///< as write_ahead's encode_output_list
  std::int64_t handler_ns = 0;
  bool last = false;  ///< of its incarnation: its outputs may have been cut off by a kill
  std::optional<std::uint64_t>
      damaged_at;            ///< byte of its record, event or outputs, whose checksum does not hold
  std::uint64_t offset = 0;  ///< of the event's record
};

/// Reads forward and allocates nothing per step. Pages that were read leave the process's memory
/// (MappedFile::forget_before), so that memory does not grow with a plain file; views stay valid.
class WalFile {
 public:
  /// @throws record::FileError
  explicit WalFile(const std::filesystem::path& path);

  enum class Item {
    kHead,     ///< head() is the next incarnation's
    kStep,     ///< step()
    kStray,    ///< outputs without their event: step().step and .outputs
    kUnknown,  ///< a record that does not decode: trouble(), offset()
    kEnd,
  };
  Item next();

  const WalHead& head() const { return head_; }
  const RecordedStep& step() const { return step_; }
  const std::string& trouble() const { return trouble_; }
  std::uint64_t offset() const { return offset_; }
  const record::DamageList& damage() const { return reader_.damage(); }
  std::uint64_t size() const { return map_.bytes().size(); }
  /// Tells that bytes of the file are read again, mostly forward: pages before them leave the process's
  /// memory. Of one thread at a time. @param bytes of a step, or elsewhere
  void read_again(std::span<const std::byte> bytes) const;

 private:
  std::optional<record::Record> take();
  void attach_outputs();

  record::MappedFile map_;
  record::RecordReader reader_;
  std::optional<record::Record> ahead_;
  WalHead head_;
  RecordedStep step_;
  std::string trouble_;
  std::uint64_t offset_ = 0;
  mutable std::uint64_t again_from_ = 0;  // the pages before have left memory
};

/// Returns the head that a write-ahead file begins with; nothing where its first record is another one or
/// damaged. Of a packed file a few records are unpacked, and its checksum is not looked at.
/// @throws record::FileError; record::PackedError
std::optional<WalHead> first_head(const std::filesystem::path& path);

}  // namespace firn::runs
