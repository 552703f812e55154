#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "core/errors/input_error.hpp"
#include "report/log/log_scan.hpp"
#include "tests/fuzz/targets.hpp"

namespace stillframe::fuzz {

namespace {

/// A file in memory, known by a path while it lives.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : file_(memfd_create("log", 0)) {
    if (file_ < 0 || write(file_, bytes.data(), bytes.size()) != std::ssize(bytes)) {
      throw std::system_error(errno, std::generic_category(), "memfd");
    }
  }
  ~MemoryFile() { close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

/// Counts, and holds every block to its first column.
class Rows : public report::LogVisitor {
 public:
  void samples(const report::SampleBlock& block) override {
    const Eigen::Index n = block.n_samples();
    require(block.sigma.rows() == n && block.floor_acceleration.rows() == n &&
                block.applied_force.rows() == n && block.frame_acceleration.rows() == n &&
                block.command_force.rows() == n,
            "a block has a row a sample");
    require(block.first_seq > last_seq_, "samples come in the order of seq");
    last_seq_ = block.first_seq + n - 1;
    n_rows_ += n;
  }
  Eigen::Index n_rows() const { return n_rows_; }

 private:
  Eigen::Index n_rows_ = 0;
  std::int64_t last_seq_ = -1;
};

}  // namespace

void log(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    Rows rows;
    // Small blocks: a large one costs more than reading these bytes.
    report::ScanSettings settings;
    settings.block_samples = settings.reorder_samples = 16;
    report::scan_log(file.path(), settings, rows);
    // A row has its measurement in the file, of 60 bytes or more with its header.
    require(static_cast<std::size_t>(rows.n_rows()) <= bytes.size() / 60,
            "no more samples than measurements");
  } catch (const InputError&) {
  }
}

}  // namespace stillframe::fuzz
