#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "tools/spacar/matlab_value.hpp"

namespace stillframe::tools::spacar {

namespace {

using Function = std::function<Value(const std::vector<Value>&)>;
constexpr double degree = std::numbers::pi / 180;
constexpr Eigen::Index most_rows = 100000;

const Eigen::MatrixXd& matrix_argument(const std::vector<Value>& arguments, std::size_t i) {
  if (i >= arguments.size()) throw Unknown("a function lacks an argument");
  if (arguments[i].type != Value::Type::numbers) throw Unknown("a function wants numbers");
  return arguments[i].numbers;
}

double scalar(const std::vector<Value>& arguments, std::size_t i) {
  const Eigen::MatrixXd& matrix = matrix_argument(arguments, i);
  if (matrix.size() != 1) throw Unknown("a function wants one number");
  return matrix(0, 0);
}

Function each(double (*function)(double)) {
  return [function](const std::vector<Value>& arguments) {
    return Value::of(Eigen::MatrixXd(matrix_argument(arguments, 0).unaryExpr(function)));
  };
}

Eigen::Index size_argument(const std::vector<Value>& arguments, std::size_t i) {
  const double size = scalar(arguments, i);
  if (size < 0 || size > static_cast<double>(most_rows)) throw Unknown("a size is out of range");
  return static_cast<Eigen::Index>(size);
}

Function filled(double value) {
  return [value](const std::vector<Value>& arguments) {
    const Eigen::Index rows = arguments.empty() ? 1 : size_argument(arguments, 0);
    const Eigen::Index cols = arguments.size() > 1 ? size_argument(arguments, 1) : rows;
    if (rows * cols > most_rows) throw Unknown("a matrix is too large");
    return Value::of(Eigen::MatrixXd::Constant(rows, cols, value));
  };
}

Value linspace(const std::vector<Value>& arguments) {
  const Eigen::Index n = arguments.size() > 2 ? size_argument(arguments, 2) : 100;
  const double from = scalar(arguments, 0), to = scalar(arguments, 1);
  return Value::of(Eigen::MatrixXd(Eigen::RowVectorXd::LinSpaced(n, from, to)));
}

Value extreme(const std::vector<Value>& arguments, bool largest) {
  if (arguments.size() == 2) {
    const double a = scalar(arguments, 0), b = scalar(arguments, 1);
    return Value::of(largest ? std::max(a, b) : std::min(a, b));
  }
  const Eigen::MatrixXd& all = matrix_argument(arguments, 0);
  if (all.size() == 0) throw Unknown("there is no largest of nothing");
  return Value::of(largest ? all.maxCoeff() : all.minCoeff());
}

Value cross(const std::vector<Value>& arguments) {
  const Eigen::MatrixXd &a = matrix_argument(arguments, 0), &b = matrix_argument(arguments, 1);
  if (a.size() != 3 || b.size() != 3) throw Unknown("cross wants two vectors of three");
  const Eigen::Vector3d left(a.reshaped()), right(b.reshaped());
  return Value::of(Eigen::MatrixXd(left.cross(right).transpose()));
}

const std::map<std::string, Function>& functions() {
  static const std::map<std::string, Function> all{
      {"sin", each([](double x) { return std::sin(x); })},
      {"cos", each([](double x) { return std::cos(x); })},
      {"tan", each([](double x) { return std::tan(x); })},
      {"asin", each([](double x) { return std::asin(x); })},
      {"acos", each([](double x) { return std::acos(x); })},
      {"atan", each([](double x) { return std::atan(x); })},
      {"sind", each([](double x) { return std::sin(x * degree); })},
      {"cosd", each([](double x) { return std::cos(x * degree); })},
      {"tand", each([](double x) { return std::tan(x * degree); })},
      {"sqrt", each([](double x) { return std::sqrt(x); })},
      {"exp", each([](double x) { return std::exp(x); })},
      {"log", each([](double x) { return std::log(x); })},
      {"log10", each([](double x) { return std::log10(x); })},
      {"abs", each([](double x) { return std::abs(x); })},
      {"floor", each([](double x) { return std::floor(x); })},
      {"ceil", each([](double x) { return std::ceil(x); })},
      {"round", each([](double x) { return std::round(x); })},
      {"double", each([](double x) { return x; })},
      {"deg2rad", each([](double x) { return x * degree; })},
      {"rad2deg", each([](double x) { return x / degree; })},
      {"atan2",
       [](const std::vector<Value>& a) {
         return Value::of(std::atan2(scalar(a, 0), scalar(a, 1)));
       }},
      {"norm", [](const std::vector<Value>& a) { return Value::of(matrix_argument(a, 0).norm()); }},
      {"sum", [](const std::vector<Value>& a) { return Value::of(matrix_argument(a, 0).sum()); }},
      {"numel",
       [](const std::vector<Value>& a) {
         return Value::of(static_cast<double>(matrix_argument(a, 0).size()));
       }},
      {"length",
       [](const std::vector<Value>& a) {
         const Eigen::MatrixXd& m = matrix_argument(a, 0);
         return Value::of(static_cast<double>(m.size() == 0 ? 0 : std::max(m.rows(), m.cols())));
       }},
      {"max", [](const std::vector<Value>& a) { return extreme(a, true); }},
      {"min", [](const std::vector<Value>& a) { return extreme(a, false); }},
      {"zeros", filled(0)},
      {"ones", filled(1)},
      {"linspace", linspace},
      {"cross", cross}};
  return all;
}

}  // namespace

bool is_function(const std::string& name) { return functions().contains(name); }

Value call_function(const std::string& name, const std::vector<Value>& arguments) {
  return functions().at(name)(arguments);
}

}  // namespace stillframe::tools::spacar
