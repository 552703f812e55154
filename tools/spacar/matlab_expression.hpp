#pragma once

#include <cstddef>

#include "tools/spacar/matlab_script.hpp"

namespace stillframe::tools::spacar {

/// A place such as nprops(3).force, and where behind it the statement goes on.
using Path = std::vector<std::pair<std::string, int>>;

/// Works out the expressions of one statement, with what the script knows so far. Errors: Unknown.
class Expression {
 public:
  Expression(const Script& script, const std::vector<Token>& tokens, std::size_t begin)
      : script_(script), tokens_(tokens), at_(begin) {}

  /// The value of all that is left of the statement.
  Value whole();
  /// The place that begins here.
  Path path();
  std::size_t at() const { return at_; }

 private:
  const Script& script_;
  const std::vector<Token>& tokens_;
  std::size_t at_;
  bool in_matrix_ = false;
  int depth_ = 0;

  const Token& now() const { return tokens_[at_]; }
  bool is(const char* symbol) const;
  bool take(const char* symbol);
  void need(const char* symbol);
  bool begins_new_element() const;

  Value range();
  Value sum();
  Value product();
  Value sign();
  Value power();
  Value primary();
  Value named();
  Value field(const Path& path) const;
  Value matrix();
  Value cell();
  std::vector<Value> arguments();
  Value part_of(const Eigen::MatrixXd& matrix);
};

}  // namespace stillframe::tools::spacar
