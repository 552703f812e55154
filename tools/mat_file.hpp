#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace stillframe::tools {

/// A MATLAB level-5 file, written beside its place under a temporary name and put there whole by
/// save(): whoever reads it never finds half of one. Set-up. Errors of every function: InputError
/// if the file cannot be written.
class MatFile {
 public:
  explicit MatFile(std::filesystem::path path);
  /// Removes what was not saved.
  ~MatFile();
  MatFile(const MatFile&) = delete;
  MatFile& operator=(const MatFile&) = delete;

  /// A matrix of doubles, bit for bit.
  void add(const std::string& name, const Eigen::MatrixXd& matrix);
  /// A column cell array of texts.
  void add(const std::string& name, const std::vector<std::string>& texts);
  void save();

 private:
  struct Handle;
  [[noreturn]] void fail() const;
  std::filesystem::path path_, temporary_;
  std::unique_ptr<Handle> handle_;
};

}  // namespace stillframe::tools
