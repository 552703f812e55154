#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "core/errors/input_error.hpp"
#include "judge/law_file.hpp"
#include "report/export/mat_file.hpp"
#include "report/export/mat_reader.hpp"
#include "tests/core/random_loops.hpp"
#include "tests/support/scratch_folder.hpp"

// What MATLAB's format is written as here (test_mat_file.cpp holds that against matio) is read
// again; what Octave writes with compression, test_octave_round_trip.cpp reads.
namespace stillframe::judge {
namespace {

using Eigen::MatrixXd;
using report::MatFile;

const std::vector<std::string> inputs{"sigma:a", "applied:a", "floor:x"}, outputs{"force:a"};
const MatrixXd A{{0.5, 0.1}, {0, 0.25}}, B{{1, 2, 3}, {4, 5, 6}}, C{{7, 8}}, D{{-1, 0.125, 1e-7}};

std::string bytes_of(const std::function<void(MatFile&)>& fill) {
  const test::ScratchFolder folder;
  const auto path = folder / "law.mat";
  {
    MatFile file(path);
    fill(file);
    file.save();
  }
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  return bytes;
}

MatrixXd one(double value) { return MatrixXd::Constant(1, 1, value); }

MatFile::Fields fields(double sample_time = 1e-3) {
  return {{"A", A},
          {"B", B},
          {"C", C},
          {"D", D},
          {"Ts", one(sample_time)},
          {"input_names", inputs},
          {"output_names", outputs}};
}

void expect_law(const LawFile& file) {
  ASSERT_TRUE(file.law);
  EXPECT_EQ(file.law->inputs, inputs);
  EXPECT_EQ(file.law->outputs, outputs);
  EXPECT_EQ(file.law->A, A);
  EXPECT_EQ(file.law->B, B);
  EXPECT_EQ(file.law->C, C);
  EXPECT_EQ(file.law->D, D);
  ASSERT_TRUE(file.sample_rate_hz);
  EXPECT_DOUBLE_EQ(*file.sample_rate_hz, 1000);
}

std::string refusal(const std::string& name, const std::string& bytes) {
  try {
    read_law_file(name, bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_refused(const std::string& name, const std::string& bytes, const std::string& what) {
  const std::string said = refusal(name, bytes);
  EXPECT_NE(said.find(what), std::string::npos) << said;
}

const char* const yaml = R"(
sample_rate_hz: 1000
inputs: ["sigma:a", "applied:a", "floor:x"]
outputs: ["force:a"]
A: [[0.5, 0.1], [0, 0.25]]
B: [[1, 2, 3], [4, 5, 6]]
C: [[7, 8]]
D: [[-1, 0.125, 1e-7]]
)";

TEST(LawFile, IsReadFromYamlAndMat) {
  expect_law(read_law_file("law.yaml", yaml));
  expect_law(read_law_file("law.mat", bytes_of([](MatFile& file) {
                             file.add_text("beside", "it");
                             file.add_struct("law", fields());
                           })));
  expect_law(read_law_file("law.mat", bytes_of([](MatFile& file) {
                             file.add("A", A);
                             file.add("B", B);
                             file.add("C", C);
                             file.add("D", D);
                             file.add("Ts", one(1e-3));
                             file.add("input_names", inputs);
                             file.add_text("output_names", outputs.front());
                           })));
}

TEST(LawFile, MayBeGainsAlone) {
  const LawFile of_yaml = read_law_file("k.yml", "K_P: [[1, 2], [3, 4]]\nK_I: [[5, 6], [7, 8]]\n"),
                of_mat = read_law_file("k.mat", bytes_of([](MatFile&file) {
                                         file.add("K_P", MatrixXd{{1, 2}, {3, 4}});
                                         file.add("K_I", MatrixXd{{5, 6}, {7, 8}});
                                       }));
  for (const LawFile& file : {of_yaml, of_mat}) {
    EXPECT_FALSE(file.law);
    EXPECT_FALSE(file.sample_rate_hz);
    EXPECT_EQ(file.K_P, (MatrixXd{{1, 2}, {3, 4}}));
    EXPECT_EQ(file.K_I, (MatrixXd{{5, 6}, {7, 8}}));
  }
}

TEST(LawFile, SaysWhatIsWrong) {
  expect_refused("law.txt", yaml, "allowed are .mat, .yaml and .yml");
  expect_refused("law.yaml", std::string(yaml) + "K_P: [[1]]\n", "either A, B, C, D or K_P, K_I");
  expect_refused("law.yaml", "K_P: [[1]]\n", "K_I");
  expect_refused("law.yaml", "inputs: [a]\n", "sample_rate_hz");
  expect_refused("law.mat", yaml, "is no MATLAB level-5 file");
  expect_refused("law.mat", "# Created by Octave 7.3", "save -v7");
  const auto changed = [](const std::string& name, const MatFile::Value& value) {
    return bytes_of([&](MatFile& file) {
      MatFile::Fields all = fields();
      for (auto& field : all) {
        if (field.first == name) field.second = value;
      }
      file.add_struct("law", all);
    });
  };
  expect_refused("law.mat", changed("Ts", one(0)), "Ts: found 0 s");
  expect_refused("law.mat", changed("Ts", MatrixXd(A)), "Ts: found a matrix of 2 x 2");
  expect_refused("law.mat", changed("A", std::string("eye(2)")), "A: found texts");
  expect_refused("law.mat", changed("D", one(std::numeric_limits<double>::quiet_NaN())),
                 "D: found a number that is not finite");
  expect_refused("law.mat", changed("input_names", MatrixXd(A)), "input_names: found a matrix");
  expect_refused("law.mat", bytes_of([](MatFile& file) { file.add("A", A); }),
                 "input_names: is missing");
}

// A file of which a part is missing or wrong is refused or read, and nothing else.
TEST(MatReader, SurvivesEveryCutAndManyWrongBytes) {
  const std::string whole = bytes_of([](MatFile& file) {
    file.add_struct("law", fields());
    file.add("texts", std::vector<std::string>{"", "\xc3\xa9t\xc3\xa9"});
  });
  std::size_t n_refused = 0;
  const auto try_it = [&](const std::string& bytes) {
    try {
      report::read_mat(bytes, "a.mat");
    } catch (const InputError&) {
      ++n_refused;
    }
  };
  for (std::size_t n = 0; n < whole.size(); ++n) try_it(whole.substr(0, n));
  EXPECT_GT(n_refused, whole.size() * 9 / 10);
  test::Draws draw(1);
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = whole;
    for (int j = 0; j < 3; ++j) {
      bytes[static_cast<std::size_t>(draw.between(124, static_cast<double>(whole.size())))] =
          static_cast<char>(draw.between(0, 256));
    }
    try_it(bytes);
  }
}

TEST(MatReader, ReadsLettersOfAnyAlphabet) {
  const report::MatValues values =
      report::read_mat(bytes_of([](MatFile& file) {
                         file.add("texts", std::vector<std::string>{"", "\xc3\xa9t\xc3\xa9"});
                         file.add("none", MatrixXd(0, 3));
                       }),
                       "a.mat");
  EXPECT_EQ(std::get<std::vector<std::string>>(values.at("texts").is),
            (std::vector<std::string>{"", "\xc3\xa9t\xc3\xa9"}));
  EXPECT_EQ(std::get<MatrixXd>(values.at("none").is).cols(), 3);
}

}  // namespace
}  // namespace stillframe::judge
