#include "report/export/mat_file.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"

namespace stillframe::report {

namespace {

using Eigen::Index;

enum class Type : std::uint32_t {
  int8 = 1,
  int32 = 5,
  uint32 = 6,
  float64 = 9,
  matrix = 14,
  utf8 = 16
};
enum class Class : std::uint32_t { cell = 1, structure = 2, text = 4, float64 = 6 };

/// Numbers stand in the order of the machine's bytes; the file's header says which that is.
std::string words(std::initializer_list<std::uint32_t> values) {
  std::string bytes(values.size() * sizeof(std::uint32_t), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

std::uint32_t number(Type type) { return static_cast<std::uint32_t>(type); }

/// Four bytes or less stand in the place of their own length.
bool is_short(std::size_t size) { return size <= 4; }

std::string element(Type type, std::string_view data) {
  const auto size = static_cast<std::uint32_t>(data.size());
  std::string bytes =
      is_short(size) ? words({size << 16 | number(type)}) : words({number(type), size});
  bytes += data;
  bytes.resize((bytes.size() + 7) / 8 * 8);
  return bytes;
}

/// A variable of `size` bytes of data, up to where these begin.
std::string header(const std::string& name, Class kind, Index n_rows, Index n_columns,
                   std::int64_t size) {
  const std::string content =
      element(Type::uint32, words({static_cast<std::uint32_t>(kind), 0})) +
      element(Type::int32,
              words({static_cast<std::uint32_t>(n_rows), static_cast<std::uint32_t>(n_columns)})) +
      element(Type::int8, name);
  return words({number(Type::matrix),
                static_cast<std::uint32_t>(static_cast<std::int64_t>(content.size()) + size)}) +
         content;
}

std::string variable(const std::string& name, Class kind, Index n_rows, Index n_columns,
                     const std::string& data) {
  return header(name, kind, n_rows, n_columns, static_cast<std::int64_t>(data.size())) + data;
}

/// UTF-8, whose size in a file is a number of letters, not of bytes.
std::string variable(const std::string& name, const std::string& text) {
  const auto begins_letter = [](char byte) { return !continues_character(byte); };
  return variable(name, Class::text, 1, std::count_if(text.begin(), text.end(), begins_letter),
                  element(Type::utf8, text));
}

std::string variable(const std::string& name, const MatFile::Texts& texts) {
  std::string cells;
  for (const std::string& text : texts) cells += variable("", text);
  return variable(name, Class::cell, static_cast<Index>(texts.size()), 1, cells);
}

std::string variable(const std::string& name, const Eigen::MatrixXd& matrix) {
  const std::string_view data(reinterpret_cast<const char*>(matrix.data()),
                              sizeof(double) * static_cast<std::size_t>(matrix.size()));
  return variable(name, Class::float64, matrix.rows(), matrix.cols(), element(Type::float64, data));
}

/// 116 bytes of text, no subsystem, the version, and how the bytes of numbers are ordered.
std::string file_header() {
  std::string bytes = "MATLAB 5.0 MAT-file, by stillframe";
  bytes.resize(116, ' ');
  bytes.resize(124, '\0');
  return bytes + words({std::uint32_t{'M' << 8 | 'I'} << 16 | 0x0100});
}

}  // namespace

MatFile::MatFile(std::filesystem::path path) : path_(std::move(path)), file_(path_) {
  file_.write(file_header());
}

void MatFile::check_size(const std::string& name, std::int64_t n_bytes) const {
  if (n_bytes < largest_variable - 1024) return;
  throw InputError(path_.string() + ": " + name + " takes " + std::to_string(n_bytes) +
                   " bytes, and a variable of a .mat file of level 5 can hold at most " +
                   std::to_string(largest_variable));
}

void MatFile::write_variable(const std::string& name, const std::string& bytes) {
  check_size(name, static_cast<std::int64_t>(bytes.size()));
  file_.write(bytes);
}

void MatFile::add(const std::string& name, const Eigen::MatrixXd& matrix) {
  write_variable(name, variable(name, matrix));
}

void MatFile::add(const std::string& name, const Texts& texts) {
  write_variable(name, variable(name, texts));
}

void MatFile::add_text(const std::string& name, const std::string& text) {
  write_variable(name, variable(name, text));
}

void MatFile::add_struct(const std::string& name, const Fields& fields) {
  constexpr std::size_t name_size = 32;  // as MATLAB has it: 31 letters and a zero
  std::string names, values;
  for (const auto& [field, value] : fields) {
    if (field.size() >= name_size) throw std::invalid_argument("this name of a field is too long");
    names += field + std::string(name_size - field.size(), '\0');
    values += std::visit([](const auto& v) { return variable("", v); }, value);
  }
  write_variable(name, variable(name, Class::structure, 1, 1,
                                element(Type::int32, words({name_size})) +
                                    element(Type::int8, names) + values));
}

std::size_t MatFile::add_rows(const std::string& name, Index n_rows, Index n_columns) {
  const std::int64_t n_bytes = 8 * static_cast<std::int64_t>(n_rows * n_columns);
  check_size(name, n_bytes);
  file_.write(header(name, Class::float64, n_rows, n_columns, 8 + n_bytes) +
              words({number(Type::float64), static_cast<std::uint32_t>(n_bytes)}));
  matrices_.push_back({file_.leave(n_bytes), n_rows, n_columns});
  return matrices_.size() - 1;
}

void MatFile::write_rows(std::size_t handle, Index first_row,
                         const Eigen::Ref<const Eigen::MatrixXd>& part) {
  const Rows& rows = matrices_.at(handle);
  if (first_row < 0 || first_row + part.rows() > rows.n_rows || part.cols() != rows.n_columns) {
    throw std::invalid_argument("these rows are no part of the matrix");
  }
  for (Index j = 0; j < part.cols(); ++j) {
    file_.write_at(rows.offset + 8 * static_cast<std::int64_t>(j * rows.n_rows + first_row),
                   {reinterpret_cast<const char*>(part.col(j).data()),
                    sizeof(double) * static_cast<std::size_t>(part.rows())});
  }
}

}  // namespace stillframe::report
