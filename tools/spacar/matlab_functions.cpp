#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "core/yaml/reader.hpp"
#include "tools/spacar/matlab_value.hpp"

namespace stillframe::tools::spacar {

namespace {

using Function = std::function<Value(const std::vector<Value>&)>;
constexpr double degree = std::numbers::pi / 180;
constexpr Eigen::Index most_rows = 100000;

const Eigen::MatrixXd& matrix_argument(const std::vector<Value>& arguments, std::size_t i) {
  if (arguments.at(i).type != Value::Type::numbers)
    throw Unknown("found a text, allowed are numbers");
  return arguments[i].numbers;
}

double scalar(const std::vector<Value>& arguments, std::size_t i) {
  const Eigen::MatrixXd& matrix = matrix_argument(arguments, i);
  if (matrix.size() != 1) throw Unknown("found a matrix, allowed is one number");
  return matrix(0, 0);
}

bool is_vector(const Eigen::MatrixXd& matrix) { return matrix.rows() == 1 || matrix.cols() == 1; }

/// Where MATLAB goes on with complex numbers there is nothing to go on with.
double real_value(double x, double value) {
  if (std::isnan(value) && !std::isnan(x)) {
    throw Unknown("found " + shortest_digits(x) + ", allowed is what has a real value");
  }
  return value;
}

Function each(double (*function)(double)) {
  return [function](const std::vector<Value>& arguments) {
    return Value::of(Eigen::MatrixXd(matrix_argument(arguments, 0).unaryExpr([&](double x) {
      return real_value(x, function(x));
    })));
  };
}

/// Two matrices of one size entry by entry, or a matrix and a number.
Value by_pairs(const std::vector<Value>& arguments, double (*function)(double, double)) {
  const Eigen::MatrixXd &a = matrix_argument(arguments, 0), &b = matrix_argument(arguments, 1);
  const bool fit = a.size() == 1 || b.size() == 1 || (a.rows() == b.rows() && a.cols() == b.cols());
  if (!fit) throw Unknown("found matrices of two sizes, allowed is one size");
  Eigen::MatrixXd out(a.size() == 1 ? b.rows() : a.rows(), a.size() == 1 ? b.cols() : a.cols());
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    out(i) = function(a(a.size() == 1 ? 0 : i), b(b.size() == 1 ? 0 : i));
  }
  return Value::of(out);
}

/// What sum, max and min do: along the dimension that the i-th argument names (1 down the columns,
/// 2 along the rows, or 'all'), without it along the first that is longer or shorter than 1.
template <class Reduction>
Value reduced(const std::vector<Value>& arguments, std::size_t i, Reduction reduction) {
  const Eigen::MatrixXd& all = matrix_argument(arguments, 0);
  double along = all.rows() == 1 ? 2 : 1;
  const bool empty = all.rows() == 0 && all.cols() == 0;
  bool whole = arguments.size() <= i && empty;
  if (arguments.size() > i) {
    if (arguments[i].type == Value::Type::text && arguments[i].text == "all") {
      whole = true;
    } else if (arguments[i].type != Value::Type::numbers || arguments[i].numbers.size() != 1) {
      throw Unknown("found another word for a dimension, allowed are 1, 2 and 'all'");
    } else {
      along = scalar(arguments, i);
    }
  }
  if (whole) return Value::of(reduction(Eigen::VectorXd(all.reshaped())));
  if (along != 1 && along != 2) {
    throw Unknown("found dimension " + shortest_digits(along) + ", allowed are 1, 2 and 'all'");
  }
  const bool down = along == 1;
  Eigen::MatrixXd out(down ? 1 : all.rows(), down ? all.cols() : 1);
  for (Eigen::Index k = 0; k < out.size(); ++k) {
    out(k) = reduction(down ? Eigen::VectorXd(all.col(k)) : Eigen::VectorXd(all.row(k)));
  }
  return Value::of(out);
}

Value sum(const std::vector<Value>& arguments) {
  return reduced(arguments, 1, [](const Eigen::VectorXd& v) { return v.sum(); });
}

// As MATLAB's, these pass over what is no number.
double larger(double a, double b) { return std::fmax(a, b); }
double smaller(double a, double b) { return std::fmin(a, b); }

/// max(A), max(A, B), and max(A, [], DIMENSION).
Value extreme(const std::vector<Value>& arguments, double (*function)(double, double)) {
  if (arguments.size() == 2) return by_pairs(arguments, function);
  if (arguments.size() == 3 && matrix_argument(arguments, 1).size() != 0) {
    throw Unknown("found 3 arguments, allowed are one, two, or a matrix, [] and a dimension");
  }
  if (matrix_argument(arguments, 0).size() == 0) throw Unknown("there is no largest of nothing");
  return reduced(arguments, 2, [&](const Eigen::VectorXd& v) {
    double value = v(0);
    for (const double entry : v) value = function(value, entry);
    return value;
  });
}

Value norm(const std::vector<Value>& arguments) {
  const Eigen::MatrixXd& v = matrix_argument(arguments, 0);
  if (v.size() > 0 && !is_vector(v)) throw Unknown("found a matrix, allowed is a vector");
  if (arguments.size() == 1) return Value::of(v.norm());
  const Value& kind = arguments[1];
  if (kind.type == Value::Type::numbers && kind.numbers.size() == 1) {
    if (kind.numbers(0, 0) == 1) return Value::of(v.lpNorm<1>());
    if (kind.numbers(0, 0) == 2) return Value::of(v.norm());
  }
  throw Unknown("found another norm, allowed are 1 and 2");
}

Eigen::Index size_argument(const std::vector<Value>& arguments, std::size_t i) {
  const double size = scalar(arguments, i);
  if (size != std::floor(size) || size < 0 || size > static_cast<double>(most_rows)) {
    throw Unknown("found size " + shortest_digits(size) + ", allowed are whole numbers to 100000");
  }
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

Value cross(const std::vector<Value>& arguments) {
  const Eigen::MatrixXd &a = matrix_argument(arguments, 0), &b = matrix_argument(arguments, 1);
  // A row and a column would do in MATLAB, and which of both comes out is not sure.
  if (a.size() != 3 || b.size() != 3 || !is_vector(a) || a.rows() != b.rows()) {
    throw Unknown("found other matrices, allowed are two rows of three, or two columns of three");
  }
  const Eigen::Vector3d left(a.reshaped()), right(b.reshaped());
  const Eigen::Vector3d out = left.cross(right);
  return Value::of(a.rows() == 1 ? Eigen::MatrixXd(out.transpose()) : Eigen::MatrixXd(out));
}

/// A function, and how many arguments it takes. More would change what MATLAB does, so they are
/// never passed over.
struct Entry {
  Function function;
  std::size_t least = 1, most = 1;
};

const std::map<std::string, Entry>& functions() {
  static const std::map<std::string, Entry> all{
      {"sin", {each([](double x) { return std::sin(x); })}},
      {"cos", {each([](double x) { return std::cos(x); })}},
      {"tan", {each([](double x) { return std::tan(x); })}},
      {"asin", {each([](double x) { return std::asin(x); })}},
      {"acos", {each([](double x) { return std::acos(x); })}},
      {"atan", {each([](double x) { return std::atan(x); })}},
      {"sind", {each([](double x) { return std::sin(x * degree); })}},
      {"cosd", {each([](double x) { return std::cos(x * degree); })}},
      {"tand", {each([](double x) { return std::tan(x * degree); })}},
      {"sqrt", {each([](double x) { return std::sqrt(x); })}},
      {"exp", {each([](double x) { return std::exp(x); })}},
      {"log", {each([](double x) { return std::log(x); })}},
      {"log10", {each([](double x) { return std::log10(x); })}},
      {"abs", {each([](double x) { return std::abs(x); })}},
      {"floor", {each([](double x) { return std::floor(x); })}},
      {"ceil", {each([](double x) { return std::ceil(x); })}},
      {"round", {each([](double x) { return std::round(x); })}},
      {"double", {each([](double x) { return x; })}},
      {"deg2rad", {each([](double x) { return x * degree; })}},
      {"rad2deg", {each([](double x) { return x / degree; })}},
      {"atan2",
       {[](const std::vector<Value>& a) {
          return by_pairs(a, [](double y, double x) { return std::atan2(y, x); });
        },
        2, 2}},
      {"norm", {norm, 1, 2}},
      {"sum", {sum, 1, 2}},
      {"numel", {[](const std::vector<Value>& a) {
         return Value::of(static_cast<double>(matrix_argument(a, 0).size()));
       }}},
      {"length", {[](const std::vector<Value>& a) {
         const Eigen::MatrixXd& m = matrix_argument(a, 0);
         return Value::of(static_cast<double>(m.size() == 0 ? 0 : std::max(m.rows(), m.cols())));
       }}},
      {"max", {[](const std::vector<Value>& a) { return extreme(a, larger); }, 1, 3}},
      {"min", {[](const std::vector<Value>& a) { return extreme(a, smaller); }, 1, 3}},
      {"zeros", {filled(0), 0, 2}},
      {"ones", {filled(1), 0, 2}},
      {"linspace", {linspace, 2, 3}},
      {"cross", {cross, 2, 2}}};
  return all;
}

}  // namespace

bool is_function(const std::string& name) { return functions().contains(name); }

Value call_function(const std::string& name, const std::vector<Value>& arguments) {
  const Entry& entry = functions().at(name);
  const std::size_t n = arguments.size();
  if (n < entry.least || n > entry.most) {
    std::string text = name + ": found " + std::to_string(n);
    text += n == 1 ? " argument, allowed " : " arguments, allowed ";
    text += entry.most == 1 ? "is " : "are ";
    text += std::to_string(entry.least);
    if (entry.most > entry.least) text += " to " + std::to_string(entry.most);
    throw Unknown(text);
  }
  try {
    return entry.function(arguments);
  } catch (const Unknown& why) {
    throw Unknown(name + ": " + why.what());
  }
}

}  // namespace stillframe::tools::spacar
