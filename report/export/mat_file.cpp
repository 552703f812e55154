#include "report/export/mat_file.hpp"

#include <matio.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "core/yaml/input_error.hpp"

namespace stillframe::report {

namespace {

using Eigen::Index;

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

/// UTF-8, whose size in a file is a number of letters, not of bytes.
Variable variable_of(const char* name, const std::string& text) {
  const auto begins_letter = [](char byte) { return (byte & 0xC0) != 0x80; };
  std::size_t size[] = {
      1, static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_letter))};
  return Variable(
      Mat_VarCreate(name, MAT_C_CHAR, MAT_T_UTF8, 2, size, const_cast<char*>(text.data()), 0));
}

Variable variable_of(const char* name, const std::vector<std::string>& texts) {
  std::size_t size[] = {texts.size(), 1};
  Variable cell(Mat_VarCreate(name, MAT_C_CELL, MAT_T_CELL, 2, size, nullptr, 0));
  for (std::size_t i = 0; cell && i < texts.size(); ++i) {
    Mat_VarSetCell(cell.get(), static_cast<int>(i), variable_of(nullptr, texts[i]).release());
  }
  return cell;
}

Variable variable_of(const char* name, const Eigen::MatrixXd& matrix) {
  std::size_t size[] = {static_cast<std::size_t>(matrix.rows()),
                        static_cast<std::size_t>(matrix.cols())};
  return Variable(Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size,
                                const_cast<double*>(matrix.data()), MAT_F_DONT_COPY_DATA));
}

/// What stands before the numbers of a matrix in a level-5 file. Source: The MathWorks, MAT-File
/// Format, "Level 5 MAT-File Format".
std::string matrix_header(const std::string& name, Index n_rows, Index n_columns,
                          std::int64_t data_size) {
  enum : std::uint32_t { int8 = 1, int32 = 5, uint32 = 6, float64 = 9, matrix = 14 };
  constexpr std::uint32_t double_class = 6;
  // Four bytes or less stand in the place of their own length.
  const bool is_short = name.size() <= 4;
  const std::size_t padded = is_short ? 4 : (name.size() + 7) / 8 * 8;
  std::string bytes;
  const auto put = [&bytes](std::initializer_list<std::uint32_t> words) {
    for (const std::uint32_t word : words) {
      char copy[sizeof word];
      std::memcpy(copy, &word, sizeof word);
      bytes.append(copy, sizeof word);
    }
  };
  const auto content = static_cast<std::uint32_t>(16 + 16 + (is_short ? 4 : 8) + padded + 8 +
                                                  static_cast<std::size_t>(data_size));
  put({matrix, content});
  put({uint32, 8, double_class, 0});
  put({int32, 8, static_cast<std::uint32_t>(n_rows), static_cast<std::uint32_t>(n_columns)});
  const auto length = static_cast<std::uint32_t>(name.size());
  if (is_short) {
    put({length << 16 | int8});
  } else {
    put({int8, length});
  }
  bytes += name + std::string(padded - name.size(), '\0');
  put({float64, static_cast<std::uint32_t>(data_size)});
  return bytes;
}

}  // namespace

/// Written by matio, and, where rows come later, by ourselves: matio can only write a matrix that
/// is in memory as a whole.
struct MatFile::Handle {
  struct Rows {
    std::int64_t offset = 0;
    Index n_rows = 0, n_columns = 0;
  };

  std::filesystem::path path, temporary;
  std::unique_ptr<mat_t, CloseFile> matio;
  std::fstream stream;
  std::vector<Rows> matrices;
  std::int64_t size = 0;

  [[noreturn]] void fail() const { throw InputError(path.string() + ": cannot be written"); }

  void check_size(const std::string& name, std::int64_t bytes) const {
    if (bytes < largest_variable - 1024) return;
    throw InputError(path.string() + ": " + name + " takes " + std::to_string(bytes) +
                     " bytes, and a variable of a .mat file of level 5 can hold at most " +
                     std::to_string(largest_variable));
  }
  void write(const Variable& variable) const {
    if (!matio) throw std::logic_error("only rows can be added behind rows");
    if (!variable || Mat_VarWrite(matio.get(), variable.get(), MAT_COMPRESSION_NONE) != 0) fail();
  }
  void close_matio() {
    if (matio && Mat_Close(matio.release()) != 0) fail();
  }
  void begin_rows() {
    if (!matio) return;
    close_matio();
    stream.open(temporary, std::ios::binary | std::ios::in | std::ios::out | std::ios::ate);
    size = static_cast<std::int64_t>(stream.tellp());
    if (!stream) fail();
  }
};

MatFile::MatFile(std::filesystem::path path) : handle_(std::make_unique<Handle>()) {
  handle_->path = std::move(path);
  handle_->temporary = handle_->path;
  handle_->temporary += ".incomplete-" + std::to_string(getpid());
  handle_->matio.reset(
      Mat_CreateVer(handle_->temporary.c_str(), "MATLAB 5.0 MAT-file, by stillframe", MAT_FT_MAT5));
  if (!handle_->matio) handle_->fail();
}

MatFile::~MatFile() {
  const std::filesystem::path temporary = handle_->temporary;
  handle_.reset();
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
}

void MatFile::add(const std::string& name, const Eigen::MatrixXd& matrix) {
  handle_->check_size(name, 8 * static_cast<std::int64_t>(matrix.size()));
  handle_->write(variable_of(name.c_str(), matrix));
}

void MatFile::add(const std::string& name, const Texts& texts) {
  handle_->write(variable_of(name.c_str(), texts));
}

void MatFile::add_text(const std::string& name, const std::string& text) {
  handle_->check_size(name, static_cast<std::int64_t>(text.size()));
  handle_->write(variable_of(name.c_str(), text));
}

void MatFile::add_struct(const std::string& name, const Fields& fields) {
  std::vector<const char*> names;
  for (const auto& [field, value] : fields) names.push_back(field.c_str());
  std::size_t size[] = {1, 1};
  const Variable variable(Mat_VarCreateStruct(name.c_str(), 2, size, names.data(),
                                              static_cast<unsigned>(names.size())));
  if (!variable) handle_->fail();
  for (const auto& [field, value] : fields) {
    Variable content = std::visit([](const auto& v) { return variable_of(nullptr, v); }, value);
    Mat_VarSetStructFieldByName(variable.get(), field.c_str(), 0, content.release());
  }
  handle_->write(variable);
}

std::size_t MatFile::add_rows(const std::string& name, Index n_rows, Index n_columns) {
  const std::int64_t data_size = 8 * static_cast<std::int64_t>(n_rows * n_columns);
  handle_->check_size(name, data_size);
  handle_->begin_rows();
  const std::string header = matrix_header(name, n_rows, n_columns, data_size);
  handle_->stream.seekp(handle_->size);
  handle_->stream.write(header.data(), static_cast<std::streamsize>(header.size()));
  handle_->size += static_cast<std::int64_t>(header.size());
  handle_->matrices.push_back({handle_->size, n_rows, n_columns});
  handle_->size += data_size;
  if (!handle_->stream.flush()) handle_->fail();
  std::error_code error;
  std::filesystem::resize_file(handle_->temporary, static_cast<std::uintmax_t>(handle_->size),
                               error);
  if (error) handle_->fail();
  return handle_->matrices.size() - 1;
}

void MatFile::write_rows(std::size_t handle, Index first_row,
                         const Eigen::Ref<const Eigen::MatrixXd>& part) {
  const Handle::Rows& rows = handle_->matrices.at(handle);
  if (first_row < 0 || first_row + part.rows() > rows.n_rows || part.cols() != rows.n_columns) {
    throw std::invalid_argument("these rows are no part of the matrix");
  }
  for (Index j = 0; j < part.cols(); ++j) {
    handle_->stream.seekp(rows.offset + 8 * static_cast<std::int64_t>(j * rows.n_rows + first_row));
    handle_->stream.write(reinterpret_cast<const char*>(part.col(j).data()),
                          static_cast<std::streamsize>(8 * part.rows()));
  }
  if (!handle_->stream) handle_->fail();
}

void MatFile::save() {
  handle_->close_matio();
  if (handle_->stream.is_open()) {
    handle_->stream.close();
    if (!handle_->stream) handle_->fail();
  }
  std::error_code error;
  std::filesystem::rename(handle_->temporary, handle_->path, error);
  if (error) handle_->fail();
}

}  // namespace stillframe::report
