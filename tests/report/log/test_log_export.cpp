// Exports of a log: every number with its bits, in its column, and never half a file.
#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "msgs/channels.hpp"
#include "report/export/log_export.hpp"
#include "report/export/mat_file.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/log/log_bytes.hpp"
#include "tests/report/log/run_fixture.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Texts = std::vector<std::string>;

class LogExport : public ::testing::Test {
 protected:
  static constexpr int n_samples = 500;

  LogExport() {
    std::mt19937_64 random(11);
    LogWriter writer(log_);
    write_full_run(writer, 42, n_samples, random);
  }
  void SetUp() override { scan_log(log_, {}, kept_); }

  long files() const {
    return std::distance(std::filesystem::directory_iterator(folder_.path()),
                         std::filesystem::directory_iterator());
  }

  /// All signals of a sample in the order of the columns.
  std::vector<std::uint64_t> wide(std::int64_t seq) const {
    const Keeper::Sample& sample = kept_.samples_by_seq.at(seq);
    std::vector<std::uint64_t> all;
    for (const auto* part :
         {&sample.floor, &sample.sigma, &sample.applied, &sample.frame, &sample.command}) {
      all.insert(all.end(), part->begin(), part->end());
    }
    return all;
  }

  test::ScratchFolder folder_;
  std::filesystem::path log_ = folder_ / "run.lcm";
  Keeper kept_;
};

Texts split(const std::string& text, const std::string& separator) {
  Texts parts;
  std::size_t begin = 0, end = 0;
  while ((end = text.find(separator, begin)) != std::string::npos) {
    parts.push_back(text.substr(begin, end - begin));
    begin = end + separator.size();
  }
  parts.push_back(text.substr(begin));
  return parts;
}

/// A NaN is written as one, whichever it was.
bool same_number(std::uint64_t bits, const std::string& text) {
  const double value = std::bit_cast<double>(bits);
  if (std::isnan(value)) return text == "NaN";
  return std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)) == bits;
}

TEST_F(LogExport, TextHoldsEveryNumber) {
  const ExportSummary summary = export_csv(log_, {}, folder_ / "run.csv");
  const Texts lines = split(bytes_of(folder_ / "run.csv"), "\r\n");
  ASSERT_EQ(lines.size(), n_samples + 2u);
  EXPECT_EQ(lines.back(), "");
  EXPECT_EQ(lines[0],
            "seq,time_s,floor:x [m/s^2],floor:y [m/s^2],sigma:leg_1 [N],sigma:leg_2 [N],sigma:leg_3"
            " [N],applied:leg_1 [N],applied:leg_2 [N],applied:leg_3 [N],frame:frame_x [m/s^2],"
            "frame:frame_y [m/s^2],command:leg_1 [N],command:leg_2 [N],command:leg_3 [N]");
  for (int seq = 0; seq < n_samples; ++seq) {
    const Texts words = split(lines[static_cast<std::size_t>(seq + 1)], ",");
    const auto expected = wide(seq);
    ASSERT_EQ(words.size(), expected.size() + 2);
    EXPECT_EQ(words[0], std::to_string(seq));
    EXPECT_EQ(std::strtod(words[1].c_str(), nullptr), kept_.samples_by_seq.at(seq).time_s);
    for (std::size_t j = 0; j < expected.size(); ++j) {
      EXPECT_TRUE(same_number(expected[j], words[j + 2])) << words[j + 2];
    }
  }
  EXPECT_EQ(summary.n_rows, n_samples);
  EXPECT_EQ(summary.n_bytes,
            static_cast<std::int64_t>(std::filesystem::file_size(folder_ / "run.csv")));
  EXPECT_EQ(summary.last_s, 0.499);
}

/// What a controller added to its commands stands with the sample that it answered, and zero where
/// nothing was added or what came was of another size, or of a sample that is not there.
TEST_F(LogExport, ExcitationWhereItIsAskedFor) {
  {
    std::mt19937_64 random(11);
    LogWriter writer(log_);
    write_full_run(writer, 42, n_samples, random);
    stillframe_msgs::excitation_t added{};
    added.run_id = 42;
    for (const std::int64_t seq : {480, 490, 499, 1'000'000'000}) {
      added.seq = seq;
      added.force = {0.25, -1.5, static_cast<double>(seq)};
      added.n_legs = 3;
      writer.write(channels::excitation, added);
    }
    added.seq = 481;
    added.force = {7};
    added.n_legs = 1;
    writer.write(channels::excitation, added);
  }
  ExportSettings settings;
  settings.channels = {"excitation"};
  export_csv(log_, settings, folder_ / "run.csv");
  const Texts lines = split(bytes_of(folder_ / "run.csv"), "\r\n");
  ASSERT_EQ(lines.size(), n_samples + 2u);
  EXPECT_EQ(lines[0], "seq,time_s,excitation:leg_1 [N],excitation:leg_2 [N],excitation:leg_3 [N]");
  int n = 0;
  for (int seq = 0; seq < n_samples; ++seq) {
    const Texts words = split(lines[static_cast<std::size_t>(seq + 1)], ",");
    const bool driven = seq == 480 || seq == 490 || seq == 499;
    n += driven;
    ASSERT_EQ(words.size(), 5u);
    EXPECT_EQ(std::stod(words[2]), driven ? 0.25 : 0) << seq;
    EXPECT_EQ(std::stod(words[3]), driven ? -1.5 : 0);
    EXPECT_EQ(std::stod(words[4]), driven ? seq : 0);
  }
  EXPECT_EQ(n, 3);
}

/// A variable of a .mat file by matio: its numbers, bit for bit, or its texts.
class MatVariable {
 public:
  MatVariable(const std::filesystem::path& file, const char* name)
      : file_(Mat_Open(file.c_str(), MAT_ACC_RDONLY)), variable_(Mat_VarRead(file_, name)) {
    EXPECT_NE(variable_, nullptr) << name;
  }
  ~MatVariable() {
    Mat_VarFree(variable_);
    Mat_Close(file_);
  }
  std::size_t rows() const { return variable_->dims[0]; }
  std::size_t columns() const { return variable_->dims[1]; }
  std::uint64_t bits(std::size_t i, std::size_t j) const {
    std::uint64_t value = 0;
    std::memcpy(&value, static_cast<const char*>(variable_->data) + 8 * (i + j * rows()), 8);
    return value;
  }
  double number() const { return std::bit_cast<double>(bits(0, 0)); }
  std::string text() const {
    return {static_cast<const char*>(variable_->data), variable_->nbytes};
  }
  Texts texts() const {
    Texts all;
    for (std::size_t i = 0; i < rows(); ++i) {
      const matvar_t* cell = Mat_VarGetCell(variable_, static_cast<int>(i));
      all.emplace_back(static_cast<const char*>(cell->data), cell->nbytes);
    }
    return all;
  }

 private:
  mat_t* file_;
  matvar_t* variable_;
};

TEST_F(LogExport, MatFileHoldsEveryNumber) {
  const std::filesystem::path file = folder_ / "run.mat";
  export_mat(log_, {}, file);
  std::size_t column = 0;
  for (const auto& [name, width] :
       std::vector<std::pair<std::string, std::size_t>>{{"floor_acceleration", 2},
                                                        {"sigma", 3},
                                                        {"applied_force", 3},
                                                        {"frame_acceleration", 2},
                                                        {"command_force", 3}}) {
    const MatVariable matrix(file, name.c_str());
    ASSERT_EQ(matrix.rows(), static_cast<std::size_t>(n_samples));
    ASSERT_EQ(matrix.columns(), width);
    for (std::size_t k = 0; k < matrix.rows(); ++k) {
      const auto expected = wide(static_cast<std::int64_t>(k));
      for (std::size_t j = 0; j < width; ++j) EXPECT_EQ(matrix.bits(k, j), expected[column + j]);
    }
    EXPECT_EQ(MatVariable(file, (name + "_names").c_str()).texts().size(), width);
    column += width;
  }
  EXPECT_EQ(MatVariable(file, "sigma_names").texts(), (Texts{"leg_1", "leg_2", "leg_3"}));
  EXPECT_EQ(MatVariable(file, "sigma_unit").text(), "N");
  EXPECT_EQ(MatVariable(file, "frame_acceleration_unit").text(), "m/s^2");
  EXPECT_EQ(MatVariable(file, "run_id").text(), "42");
  EXPECT_EQ(MatVariable(file, "sample_rate_hz").number(), 1000);
  const MatVariable seq(file, "seq"), time(file, "time_s");
  for (std::size_t k = 0; k < n_samples; ++k) {
    EXPECT_EQ(std::bit_cast<double>(seq.bits(k, 0)), static_cast<double>(k));
    EXPECT_EQ(std::bit_cast<double>(time.bits(k, 0)),
              kept_.samples_by_seq.at(static_cast<std::int64_t>(k)).time_s);
  }
}

TEST_F(LogExport, ChannelsAndTimesAreChosen) {
  ExportSettings settings;
  settings.channels = {"frame", "sigma:leg_2"};
  settings.from_s = 0.1;
  settings.to_s = 0.2;
  const ExportSummary csv = export_csv(log_, settings, folder_ / "part.csv");
  EXPECT_EQ(csv.n_rows, 101);  // both ends
  const Texts lines = split(bytes_of(folder_ / "part.csv"), "\r\n");
  EXPECT_EQ(lines[0], "seq,time_s,sigma:leg_2 [N],frame:frame_x [m/s^2],frame:frame_y [m/s^2]");
  EXPECT_EQ(split(lines[1], ",")[0], "100");
  EXPECT_TRUE(same_number(wide(100)[3], split(lines[1], ",")[2]));
  export_mat(log_, settings, folder_ / "part.mat");
  const MatVariable sigma(folder_ / "part.mat", "sigma");
  EXPECT_EQ(sigma.rows(), 101u);
  EXPECT_EQ(sigma.columns(), 1u);
  EXPECT_EQ(sigma.bits(100, 0), wide(200)[3]);
  EXPECT_EQ(MatVariable(folder_ / "part.mat", "sigma_names").texts(), (Texts{"leg_2"}));
}

TEST_F(LogExport, LostSamplesHaveNoRowAndMissingAnswersAreNaN) {
  {
    LogWriter writer(log_);
    writer.write(channels::run_info, sample_info(1, 6));
    for (const int seq : {0, 1, 4, 5}) {
      writer.write(channels::measurement, sample_measurement(1, seq));
      if (seq != 1) writer.write(channels::command, sample_command(1, seq));
    }
  }
  const ExportSummary summary = export_csv(log_, {}, folder_ / "run.csv");
  EXPECT_EQ(summary.n_rows, 4);
  EXPECT_EQ(summary.scan.measurements.n_lost, 2);
  const Texts lines = split(bytes_of(folder_ / "run.csv"), "\r\n");
  EXPECT_TRUE(lines[2].starts_with("1,0.001,1.1,1.2,"));
  EXPECT_TRUE(lines[2].ends_with(",NaN,NaN,NaN")) << lines[2];
  EXPECT_TRUE(lines[3].starts_with("4,0.004,"));
  export_mat(log_, {}, folder_ / "run.mat");
  EXPECT_EQ(std::bit_cast<double>(MatVariable(folder_ / "run.mat", "seq").bits(2, 0)), 4);
}

/// More than twice the rows that are written at a time.
TEST_F(LogExport, LongRunsAreWrittenPartByPart) {
  constexpr std::int64_t n = 40'000;
  {
    LogWriter writer(log_);
    write_run(writer, 1, n);
  }
  export_mat(log_, {}, folder_ / "run.mat");
  const MatVariable seq(folder_ / "run.mat", "seq"), sigma(folder_ / "run.mat", "sigma");
  ASSERT_EQ(sigma.rows(), static_cast<std::size_t>(n));
  for (std::int64_t k = 0; k < n; ++k) {
    const auto row = static_cast<std::size_t>(k);
    ASSERT_EQ(std::bit_cast<double>(seq.bits(row, 0)), static_cast<double>(k));
    ASSERT_EQ(sigma.bits(row, 2), bits(sample_measurement(1, k).sigma)[2]);
  }
}

TEST_F(LogExport, NamesAreQuotedAsTheyMustBe) {
  {
    LogWriter writer(log_);
    auto info = sample_info(1, 1);
    info.leg_names = {"a,b", "c\"d", "e"};
    writer.write(channels::run_info, info);
    writer.write(channels::measurement, sample_measurement(1, 0));
  }
  ExportSettings settings;
  settings.channels = {"sigma"};
  export_csv(log_, settings, folder_ / "run.csv");
  EXPECT_EQ(split(bytes_of(folder_ / "run.csv"), "\r\n")[0],
            "seq,time_s,\"sigma:a,b [N]\",\"sigma:c\"\"d [N]\",sigma:e [N]");
}

TEST_F(LogExport, WhatCannotBeDoneLeavesTheOldFile) {
  write_bytes_to(folder_ / "old", "old");
  const auto refuses = [&](const ExportSettings& settings, const std::string& message) {
    for (const auto& how : {export_csv, export_mat}) {
      expect_error<InputError>([&] { how(log_, settings, folder_ / "old"); }, message);
      EXPECT_EQ(bytes_of(folder_ / "old"), "old");
      EXPECT_EQ(files(), 2);
    }
  };
  ExportSettings settings;
  settings.channels = {"floor", "tilt"};
  refuses(settings,
          "--channels: found 'tilt', this log holds floor, sigma, applied, frame, "
          "command, excitation, floor:x, floor:y, sigma:leg_1");
  settings = {};
  settings.from_s = 7;
  refuses(settings, "no sample between --from and --to; the run goes from 0 to 0.499 s");
  settings = {};
  settings.run_id = 5;
  refuses(settings, "found none with 5");
  for (const auto& how : {export_csv, export_mat}) {
    expect_error<InputError>([&] { how(log_, {}, folder_ / "none/a"); },
                             "none/a: cannot be written");
  }
}

TEST_F(LogExport, RowsComeInPartsAndAnyOrder) {
  const std::filesystem::path file = folder_ / "rows.mat";
  {
    MatFile mat(file);
    mat.add_text("before", "\xC3\xA9t\xC3\xA9");
    // Names around the four bytes that stand in their own length, and the eight of the padding.
    std::vector<std::size_t> handles;
    for (const char* name : {"a", "abc", "abcd", "abcde", "abcdefgh", "abcdefghi"}) {
      handles.push_back(mat.add_rows(name, 5, 2));
    }
    for (const std::size_t handle : handles) {
      const double v = static_cast<double>(handle);
      mat.write_rows(handle, 3, (Eigen::MatrixXd(2, 2) << v + 4, v + 40, v + 5, v + 50).finished());
      mat.write_rows(handle, 0, (Eigen::MatrixXd(1, 2) << v + 1, v + 10).finished());
    }
    EXPECT_THROW(mat.write_rows(0, 4, Eigen::MatrixXd::Zero(2, 2)), std::invalid_argument);
    EXPECT_THROW(mat.write_rows(0, -1, Eigen::MatrixXd::Zero(1, 2)), std::invalid_argument);
    EXPECT_THROW(mat.write_rows(0, 0, Eigen::MatrixXd::Zero(1, 3)), std::invalid_argument);
    mat.add_text("behind", "x");
    EXPECT_FALSE(std::filesystem::exists(file));
    mat.save();
  }
  EXPECT_EQ(MatVariable(file, "before").text(), "\xC3\xA9t\xC3\xA9");
  EXPECT_EQ(MatVariable(file, "behind").text(), "x");
  double v = 0;
  for (const char* name : {"a", "abc", "abcd", "abcde", "abcdefgh", "abcdefghi"}) {
    const MatVariable matrix(file, name);
    const double expected[5][2] = {
        {v + 1, v + 10}, {0, 0}, {0, 0}, {v + 4, v + 40}, {v + 5, v + 50}};
    for (std::size_t i = 0; i < 5; ++i) {
      for (std::size_t j = 0; j < 2; ++j) {
        EXPECT_EQ(std::bit_cast<double>(matrix.bits(i, j)), expected[i][j]) << name;
      }
    }
    ++v;
  }
}

TEST_F(LogExport, AMatrixBeyondTheFormatIsRefused) {
  MatFile mat(folder_ / "large.mat");
  expect_error<InputError>([&] { mat.add_rows("sigma", 50'000'000, 6); },
                           "sigma takes 2400000000 bytes, and a variable of a .mat file of level 5 "
                           "can hold at most 2147483647");
}

}  // namespace
}  // namespace stillframe::report
