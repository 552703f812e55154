#include <matio.h>

#include <fstream>

#include "core/errors/input_error.hpp"
#include "report/export/mat_file.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

class MatFileTest : public Verb {
 protected:
  std::string text() const {
    std::ifstream stream(folder_ / "a.mat");
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  long files() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }
};

TEST_F(MatFileTest, NothingIsThereBeforeItIsSaved) {
  write("a.mat", "an older file");
  {
    report::MatFile file(folder_ / "a.mat");
    file.add("A", Eigen::MatrixXd::Identity(2, 2));
    EXPECT_EQ(text(), "an older file");
  }
  EXPECT_EQ(text(), "an older file");
  EXPECT_EQ(files(), 1);
  report::MatFile file(folder_ / "a.mat");
  file.save();
  EXPECT_TRUE(text().starts_with("MATLAB 5.0 MAT-file"));
  EXPECT_EQ(files(), 1);
}

TEST_F(MatFileTest, EmptyMatricesAndTextsAreRead) {
  report::MatFile file(folder_ / "a.mat");
  file.add("none", Eigen::MatrixXd(0, 3));
  file.add("no_texts", std::vector<std::string>{});
  file.add("texts", std::vector<std::string>{"", "\xc3\xa9t\xc3\xa9"});
  file.save();
  mat_t* mat = Mat_Open((folder_ / "a.mat").c_str(), MAT_ACC_RDONLY);
  ASSERT_NE(mat, nullptr);
  const auto size_of = [&](const char* name) {
    matvar_t* variable = Mat_VarRead(mat, name);
    const std::pair<size_t, size_t> size =
        variable != nullptr ? std::pair(variable->dims[0], variable->dims[1]) : std::pair(9ul, 9ul);
    Mat_VarFree(variable);
    return size;
  };
  EXPECT_EQ(size_of("none"), std::pair(0ul, 3ul));
  EXPECT_EQ(size_of("no_texts"), std::pair(0ul, 1ul));
  matvar_t* texts = Mat_VarRead(mat, "texts");
  ASSERT_NE(texts, nullptr);
  const matvar_t* second = Mat_VarGetCell(texts, 1);
  EXPECT_EQ(std::string(static_cast<const char*>(second->data), second->nbytes),
            "\xc3\xa9t\xc3\xa9");
  Mat_VarFree(texts);
  Mat_Close(mat);
}

TEST_F(MatFileTest, AFolderThatIsNotThereIsAnInputError) {
  EXPECT_THROW(report::MatFile(folder_ / "none/a.mat"), InputError);
}

}  // namespace
}  // namespace stillframe::test
