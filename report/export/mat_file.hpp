#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/files/whole_file.hpp"

namespace stillframe::report {

/// A MATLAB level-5 file, a WholeFile: it is there when it has been saved. Set-up. Errors of every
/// function: those of WholeFile, and InputError if a variable would be larger than the format
/// allows. Source: The MathWorks, MAT-File Format, "Level 5 MAT-File Format".
class MatFile {
 public:
  /// The most bytes of one variable, its own header included.
  static constexpr std::int64_t largest_variable = (std::int64_t{1} << 31) - 1;

  explicit MatFile(std::filesystem::path path);
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

  /// A matrix whose rows come later, part by part, in any order; zeros until then. Answers a handle
  /// for write_rows.
  std::size_t add_rows(const std::string& name, Eigen::Index n_rows, Eigen::Index n_columns);
  /// Throws std::invalid_argument if the part does not lie in the matrix.
  void write_rows(std::size_t handle, Eigen::Index first_row,
                  const Eigen::Ref<const Eigen::MatrixXd>& part);

  std::int64_t size() const { return file_.size(); }  ///< bytes
  void save() { file_.save(); }

 private:
  struct Rows {
    std::int64_t offset = 0;
    Eigen::Index n_rows = 0, n_columns = 0;
  };
  void check_size(const std::string& name, std::int64_t n_bytes) const;
  void write_variable(const std::string& name, const std::string& bytes);

  std::filesystem::path path_;
  WholeFile file_;
  std::vector<Rows> matrices_;
};

}  // namespace stillframe::report
