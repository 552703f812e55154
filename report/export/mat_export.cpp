#include <algorithm>

#include "report/export/chosen_rows.hpp"
#include "report/export/mat_file.hpp"

namespace stillframe::report {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Rows that are kept until they are worth a call of the system for each column.
constexpr Index part_rows = 16384;

/// The chosen columns of one group, as one matrix of the file.
struct Part {
  std::string variable;
  const SignalGroup* group;
  std::vector<Index> columns;
  std::size_t handle = 0;
  MatrixXd rows;
};

std::vector<Part> parts_of(const std::vector<SignalColumn>& columns) {
  std::vector<Part> parts;
  for (const SignalColumn& column : columns) {
    if (parts.empty() || parts.back().group != column.group) {
      parts.push_back({column.group->variable, column.group, {}, 0, {}});
    }
    parts.back().columns.push_back(column.column);
  }
  return parts;
}

void check_sizes(const ExportSummary& found, const std::filesystem::path& path) {
  for (const Part& part : parts_of(found.columns)) {
    const std::int64_t n_bytes = 8 * found.n_rows * static_cast<std::int64_t>(part.columns.size());
    if (n_bytes < MatFile::largest_variable - 1024) continue;
    throw InputError(path.string() + ": " + part.variable + " of " + std::to_string(found.n_rows) +
                     " samples and " + std::to_string(part.columns.size()) + " signals takes " +
                     std::to_string(n_bytes) +
                     " bytes, a variable of a .mat file of level 5 holds at most 2147483647; take "
                     "less by --from, --to or --channels, or write --csv");
  }
}

class MatRows : public ChosenRows {
 public:
  MatRows(const ExportSettings& settings, MatFile& file, std::int64_t n_rows)
      : ChosenRows(settings), file_(file), n_rows_(n_rows) {}

  void flush() {
    if (filled_ == 0) return;
    file_.write_rows(seq_handle_, written_, seq_.topRows(filled_));
    file_.write_rows(time_handle_, written_, time_.topRows(filled_));
    for (const Part& part : parts_) {
      file_.write_rows(part.handle, written_, part.rows.topRows(filled_));
    }
    written_ += filled_;
    filled_ = 0;
  }

 protected:
  void ready(const stillframe_msgs::run_info_t& info) override {
    parts_ = parts_of(summary().columns);
    describe(info);
    const auto n = static_cast<Index>(n_rows_);
    seq_handle_ = file_.add_rows("seq", n, 1);
    time_handle_ = file_.add_rows("time_s", n, 1);
    seq_.resize(part_rows, 1), time_.resize(part_rows, 1);
    for (Part& part : parts_) {
      const auto n_columns = static_cast<Index>(part.columns.size());
      part.handle = file_.add_rows(part.variable, n, n_columns);
      part.rows.resize(part_rows, n_columns);
    }
  }

  void row(const SampleBlock& block, Index k) override {
    seq_(filled_, 0) = static_cast<double>(block.first_seq + k);
    time_(filled_, 0) = block.time_s(k);
    for (Part& part : parts_) {
      const MatrixXd& values = block.*part.group->values;
      for (std::size_t j = 0; j < part.columns.size(); ++j) {
        part.rows(filled_, static_cast<Index>(j)) = values(k, part.columns[j]);
      }
    }
    if (++filled_ == part_rows) flush();
  }

 private:
  void describe(const stillframe_msgs::run_info_t& info) {
    file_.add_text("scene", info.scene_name);
    file_.add_text("scene_hash", info.scene_hash);
    file_.add_text("run_id", std::to_string(info.run_id));  // a double has fewer digits
    file_.add_text("mode", info.mode);
    file_.add_text("loop", info.loop);
    file_.add("sample_rate_hz", MatrixXd(MatrixXd::Constant(1, 1, info.sample_rate_hz)));
    file_.add("delay_samples", MatrixXd(MatrixXd::Constant(1, 1, info.delay_samples)));
    for (const Part& part : parts_) {
      MatFile::Texts names;
      for (const Index j : part.columns) {
        names.push_back((info.*part.group->names)[static_cast<std::size_t>(j)]);
      }
      file_.add(part.variable + "_names", names);
      file_.add_text(part.variable + "_unit", part.group->unit);
    }
  }

  MatFile& file_;
  std::int64_t n_rows_;
  std::vector<Part> parts_;
  std::size_t seq_handle_ = 0, time_handle_ = 0;
  MatrixXd seq_, time_;
  Index filled_ = 0, written_ = 0;
};

}  // namespace

ExportSummary export_mat(const std::filesystem::path& log, const ExportSettings& settings,
                         const std::filesystem::path& path) {
  MatFile file(path);
  // A level-5 file says the size of a matrix before its numbers.
  ChosenRows counted(settings);
  counted.read(log, 0, 0.5);
  check_sizes(counted.summary(), path);
  MatRows rows(settings, file, counted.summary().n_rows);
  rows.read(log, 0.5, 1);
  rows.flush();
  file.save();
  rows.summary().n_bytes = file.size();
  return std::move(rows.summary());
}

}  // namespace stillframe::report
