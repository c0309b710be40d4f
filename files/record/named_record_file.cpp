#include "files/record/named_record_file.h"

#include <unistd.h>

#include <string>
#include <system_error>

#include "files/record/output_target.h"

namespace firn::record {

namespace fs = std::filesystem;

NamedRecordFile::NamedRecordFile(const fs::path& file)
    : file_(output_target(file)),
      part_(file_.string() + ".part-" + std::to_string(getpid())),
      out_(std::make_unique<RecordWriter>(part_.path(), RecordWriter::Mode::kCreate)) {}

NamedRecordFile::~NamedRecordFile() {
  if (!out_) return;
  part_.remove();
}

void NamedRecordFile::finish() {
  out_->sync();
  bytes_ = out_->bytes();
  out_->close();
  std::error_code error;
  fs::rename(part_.path(), file_, error);
  if (error) throw FileError(file_, 0, "cannot be given its name", error.value());
  out_.reset();
}

}  // namespace firn::record
