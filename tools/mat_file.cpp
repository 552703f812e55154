#include "tools/mat_file.hpp"

#include <matio.h>
#include <unistd.h>

#include <algorithm>

#include "core/yaml/input_error.hpp"

namespace stillframe::tools {

namespace {

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

/// UTF-8, whose size in a file is a number of letters, not of bytes.
Variable text_variable(const std::string& text) {
  const auto begins_letter = [](char byte) { return (byte & 0xC0) != 0x80; };
  std::size_t size[] = {
      1, static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_letter))};
  return Variable(
      Mat_VarCreate(nullptr, MAT_C_CHAR, MAT_T_UTF8, 2, size, const_cast<char*>(text.data()), 0));
}

}  // namespace

struct MatFile::Handle {
  std::unique_ptr<mat_t, CloseFile> file;
  void write(matvar_t* variable, const MatFile& owner) const {
    if (variable == nullptr || Mat_VarWrite(file.get(), variable, MAT_COMPRESSION_NONE) != 0) {
      owner.fail();
    }
  }
};

MatFile::MatFile(std::filesystem::path path)
    : path_(std::move(path)), handle_(std::make_unique<Handle>()) {
  temporary_ = path_;
  temporary_ += ".incomplete-" + std::to_string(getpid());
  handle_->file.reset(
      Mat_CreateVer(temporary_.c_str(), "MATLAB 5.0 MAT-file, by stillframe", MAT_FT_MAT5));
  if (!handle_->file) fail();
}

MatFile::~MatFile() {
  handle_.reset();
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void MatFile::fail() const { throw InputError(path_.string() + ": cannot be written"); }

void MatFile::add(const std::string& name, const Eigen::MatrixXd& matrix) {
  std::size_t size[] = {static_cast<std::size_t>(matrix.rows()),
                        static_cast<std::size_t>(matrix.cols())};
  const Variable variable(Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size,
                                        const_cast<double*>(matrix.data()), MAT_F_DONT_COPY_DATA));
  handle_->write(variable.get(), *this);
}

void MatFile::add(const std::string& name, const std::vector<std::string>& texts) {
  std::size_t size[] = {texts.size(), 1};
  const Variable cell(Mat_VarCreate(name.c_str(), MAT_C_CELL, MAT_T_CELL, 2, size, nullptr, 0));
  if (!cell) fail();
  for (std::size_t i = 0; i < texts.size(); ++i) {
    Mat_VarSetCell(cell.get(), static_cast<int>(i), text_variable(texts[i]).release());
  }
  handle_->write(cell.get(), *this);
}

void MatFile::save() {
  if (Mat_Close(handle_->file.release()) != 0) fail();
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) fail();
}

}  // namespace stillframe::tools
