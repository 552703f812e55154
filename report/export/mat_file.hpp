#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stillframe::report {

/// A MATLAB level-5 file, written beside its place under a temporary name and put there whole by
/// save(): whoever reads it never finds half of one. Set-up. Errors of every function: InputError
/// if the file cannot be written, or if a variable would be larger than the format allows.
class MatFile {
 public:
  /// The most bytes of one variable, its own header included.
  static constexpr std::int64_t largest_variable = (std::int64_t{1} << 31) - 1;

  explicit MatFile(std::filesystem::path path);
  /// Removes what was not saved.
  ~MatFile();
  MatFile(const MatFile&) = delete;
  MatFile& operator=(const MatFile&) = delete;

  using Texts = std::vector<std::string>;
  using Value = std::variant<Eigen::MatrixXd, Texts, std::string>;
  using Fields = std::vector<std::pair<std::string, Value>>;

  /// A matrix of doubles, bit for bit.
  void add(const std::string& name, const Eigen::MatrixXd& matrix);
  /// A column cell array of texts.
  void add(const std::string& name, const Texts& texts);
  void add_text(const std::string& name, const std::string& text);
  /// A structure of such values.
  void add_struct(const std::string& name, const Fields& fields);

  /// A matrix whose rows come later, part by part, in any order; zeros until then. Nothing but such
  /// matrices can be added behind it. Answers a handle for write_rows.
  std::size_t add_rows(const std::string& name, Eigen::Index n_rows, Eigen::Index n_columns);
  /// Throws std::invalid_argument if the part does not lie in the matrix.
  void write_rows(std::size_t handle, Eigen::Index first_row,
                  const Eigen::Ref<const Eigen::MatrixXd>& part);

  void save();

 private:
  struct Handle;
  std::unique_ptr<Handle> handle_;
};

}  // namespace stillframe::report
