#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>
#include <vector>

namespace stillframe::tools::spacar {

/// A value of a script: a matrix of numbers (true is 1), a text, or a cell of values.
struct Value {
  enum class Type { numbers, text, cell };
  Type type = Type::numbers;
  Eigen::MatrixXd numbers;
  std::string text;
  std::vector<Value> cell;

  static Value of(Eigen::MatrixXd matrix) {
    Value value;
    value.numbers = std::move(matrix);
    return value;
  }
  static Value of(double number) { return of(Eigen::MatrixXd::Constant(1, 1, number).eval()); }
  static Value of_text(std::string text) {
    Value value;
    value.type = Type::text;
    value.text = std::move(text);
    return value;
  }
};

/// What cannot be worked out, in a few words; the line is known to whoever asked.
class Unknown : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A function of MATLAB's on values, of those that models are written with. Errors: Unknown.
bool is_function(const std::string& name);
Value call_function(const std::string& name, const std::vector<Value>& arguments);

}  // namespace stillframe::tools::spacar
