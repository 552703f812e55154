#include <charconv>
#include <cmath>

#include "core/files/whole_file.hpp"
#include "report/export/chosen_rows.hpp"

namespace stillframe::report {

namespace {

constexpr const char* end_of_row = "\r\n";

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

class CsvRows : public ChosenRows {
 public:
  CsvRows(const ExportSettings& settings, WholeFile& file) : ChosenRows(settings), file_(file) {}

 protected:
  void ready(const stillframe_msgs::run_info_t&) override {
    std::string header = "seq,time_s";
    for (const SignalColumn& column : summary().columns) {
      header += "," + quoted(column.label() + " [" + column.group->unit + "]");
    }
    file_.write(header + end_of_row);
  }

  void row(const SampleBlock& block, Eigen::Index k) override {
    line_ = std::to_string(block.first_seq + k);
    put(block.time_s(k));
    for (const SignalColumn& column : summary().columns) {
      put((block.*column.group->values)(k, column.column));
    }
    file_.write(line_ += end_of_row);
  }

 private:
  void put(double value) {
    line_ += ',';
    if (std::isfinite(value)) {
      char text[32];
      line_.append(text, std::to_chars(std::begin(text), std::end(text), value).ptr);
    } else {
      line_ += std::isnan(value) ? "NaN" : value > 0 ? "Inf" : "-Inf";
    }
  }

  WholeFile& file_;
  std::string line_;
};

}  // namespace

ExportSummary export_csv(const std::filesystem::path& log, const ExportSettings& settings,
                         const std::filesystem::path& path) {
  WholeFile file(path);
  CsvRows rows(settings, file);
  rows.read(log);
  file.save();
  rows.summary().n_bytes = file.size();
  return std::move(rows.summary());
}

}  // namespace stillframe::report
