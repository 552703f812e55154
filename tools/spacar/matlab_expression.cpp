#include "tools/spacar/matlab_expression.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/spacar/source_text.hpp"

namespace stillframe::tools::spacar {

namespace {

std::string set_hint(const std::string& name) {
  return "; --set " + shown(name) + "=VALUE says it";
}

/// Deeper than any model, and shallower than the stack.
constexpr int most_depth = 100;
constexpr double most_entries = 100000;

const Eigen::MatrixXd& numbers_of(const Value& value) {
  if (value.type != Value::Type::numbers) throw Unknown("a text stands where a number belongs");
  return value.numbers;
}

/// A few lines can ask for more than there is memory.
void require_size(Eigen::Index rows, Eigen::Index cols) {
  if (static_cast<double>(rows) * static_cast<double>(cols) > most_entries) {
    throw Unknown("a matrix is too large");
  }
}

double add(double a, double b) { return a + b; }
double subtract(double a, double b) { return a - b; }
double multiply(double a, double b) { return a * b; }
double divide(double a, double b) { return a / b; }

double real_power(double a, double b) {
  const double value = std::pow(a, b);
  if (std::isnan(value) && !std::isnan(a) && !std::isnan(b)) {
    throw Unknown("a power of a negative number has no real value");
  }
  return value;
}

/// An operation entry by entry, with a scalar on either side as in MATLAB.
template <class Operation>
Value by_entries(const Value& left, const Value& right, Operation operation) {
  const Eigen::MatrixXd &a = numbers_of(left), &b = numbers_of(right);
  if (a.size() == 1) {
    const double scalar = a(0, 0);
    return Value::of(Eigen::MatrixXd(b.unaryExpr([&](double x) { return operation(scalar, x); })));
  }
  if (b.size() == 1) {
    const double scalar = b(0, 0);
    return Value::of(Eigen::MatrixXd(a.unaryExpr([&](double x) { return operation(x, scalar); })));
  }
  if (a.rows() != b.rows() || a.cols() != b.cols()) throw Unknown("two matrices of other sizes");
  return Value::of(Eigen::MatrixXd(a.binaryExpr(b, operation)));
}

double single(const Value& value) {
  if (numbers_of(value).size() != 1) throw Unknown("a matrix stands where one number belongs");
  return value.numbers(0, 0);
}

Value times(const Value& left, const Value& right) {
  const Eigen::MatrixXd &a = numbers_of(left), &b = numbers_of(right);
  if (a.size() == 1 || b.size() == 1) return by_entries(left, right, multiply);
  if (a.cols() != b.rows()) throw Unknown("a product of matrices that do not fit");
  require_size(a.rows(), b.cols());
  return Value::of(Eigen::MatrixXd(a * b));
}

Eigen::Index index_of(double number, Eigen::Index size) {
  if (number != std::floor(number) || number < 1 || number > static_cast<double>(size)) {
    throw Unknown("an index is outside of its matrix");
  }
  return static_cast<Eigen::Index>(number) - 1;
}

}  // namespace

bool Expression::is(const char* symbol) const {
  return now().kind == TokenKind::symbol && now().text == symbol;
}

bool Expression::take(const char* symbol) {
  if (!is(symbol)) return false;
  ++at_;
  return true;
}

void Expression::need(const char* symbol) {
  if (!take(symbol)) throw Unknown(std::string("there is no '") + symbol + "' where one belongs");
}

Value Expression::whole() {
  Value value = range();
  if (now().kind != TokenKind::end) {
    throw Unknown("'" + shown(now().text) + "' is nothing that is read here");
  }
  return value;
}

/// In a matrix [1 -2] has two entries and [1 - 2] one.
bool Expression::begins_new_element() const {
  return in_matrix_ && now().space_before && !now().space_after;
}

Value Expression::range() {
  if (++depth_ > most_depth) throw Unknown("brackets stand too deep");
  Value first = sum();
  if (is(":")) {
    ++at_;
    Value second = sum();
    double from = single(first), step = 1, to = single(second);
    if (take(":")) {
      step = to;
      to = single(sum());
    }
    const double count = std::floor((to - from) / step * (1 + 1e-15) + 1e-10) + 1;
    if (step == 0 || !(count < most_entries)) throw Unknown("a range has no end");
    Eigen::MatrixXd row(1, count < 1 ? 0 : static_cast<Eigen::Index>(count));
    for (Eigen::Index i = 0; i < row.cols(); ++i) row(0, i) = from + static_cast<double>(i) * step;
    first = Value::of(row);
  }
  --depth_;
  return first;
}

Value Expression::sum() {
  Value value = product();
  while ((is("+") || is("-")) && !begins_new_element()) {
    const bool minus = is("-");
    ++at_;
    const Value right = product();
    value = minus ? by_entries(value, right, subtract) : by_entries(value, right, add);
  }
  return value;
}

Value Expression::product() {
  Value value = sign();
  for (;;) {
    if (take("*")) {
      value = times(value, sign());
    } else if (take(".*")) {
      value = by_entries(value, sign(), multiply);
    } else if (take("./")) {
      value = by_entries(value, sign(), divide);
    } else if (take("/")) {
      const Value right = sign();
      static_cast<void>(single(right));
      value = by_entries(value, right, divide);
    } else {
      return value;
    }
  }
}

Value Expression::sign() {
  while (take("+")) {
  }
  if (take("-")) {
    if (++depth_ > most_depth) throw Unknown("signs stand too deep");
    Value value = by_entries(Value::of(-1.0), sign(), multiply);
    --depth_;
    return value;
  }
  return power();
}

/// Powers and transposes bind alike and from the left: a.^2' is (a.^2)'.
Value Expression::power() {
  Value value = primary();
  for (;;) {
    if (take("'") || take(".'")) {
      value = Value::of(Eigen::MatrixXd(numbers_of(value).transpose()));
      continue;
    }
    if (!is("^") && !is(".^")) return value;
    const bool by_entry = is(".^");
    ++at_;
    // The sign of an exponent belongs to it: 2^-3.
    const bool minus = take("-");
    Value exponent = primary();
    if (minus) exponent = by_entries(Value::of(-1.0), exponent, multiply);
    if (!by_entry) static_cast<void>(single(value));
    if (!by_entry) static_cast<void>(single(exponent));
    value = by_entries(value, exponent, real_power);
  }
}

Value Expression::primary() {
  const Token& token = now();
  if (token.kind == TokenKind::number) {
    ++at_;
    return Value::of(token.number);
  }
  if (token.kind == TokenKind::text) {
    ++at_;
    return Value::of_text(token.text);
  }
  if (token.kind == TokenKind::name) return named();
  if (take("(")) {
    const bool outer = in_matrix_;
    in_matrix_ = false;
    Value value = range();
    in_matrix_ = outer;
    need(")");
    return value;
  }
  if (take("[")) return matrix();
  if (take("{")) return cell();
  throw Unknown(token.kind == TokenKind::end ? "the statement ends too early"
                                             : "'" + shown(token.text) + "' is not read here");
}

Value Expression::named() {
  const std::string name = now().text;
  const bool fields = std::any_of(script_.fields.begin(), script_.fields.end(),
                                  [&](const Assigned& a) { return a.path.front().first == name; });
  const Token& next = tokens_[at_ + 1];
  if (fields || (next.kind == TokenKind::symbol && next.text == "." && !next.space_before)) {
    return field(path());
  }
  ++at_;
  const bool indexed = is("(") && !(in_matrix_ && now().space_before);
  const auto found = script_.variables.find(name);
  if (found != script_.variables.end()) {
    if (!indexed) return found->second.first;
    ++at_;
    return part_of(numbers_of(found->second.first));
  }
  if (script_.unknown.contains(name)) throw Unknown("'" + name + "' is not known");
  if (name == "pi") return Value::of(std::numbers::pi);
  if (name == "true") return Value::of(1.0);
  if (name == "false") return Value::of(0.0);
  if (name == "eps") return Value::of(std::numeric_limits<double>::epsilon());
  if (!is_function(name)) {
    const bool called = indexed && !in_matrix_;
    throw Unknown("'" + shown(name) + "' is not known" + (called ? "" : set_hint(name)));
  }
  if (!indexed) return call_function(name, {});
  ++at_;
  return call_function(name, arguments());
}

Value Expression::field(const Path& path) const {
  for (const Assigned& assigned : script_.fields) {
    if (assigned.path == path) return assigned.value;
  }
  std::string name;
  for (const auto& [field, index] : path) {
    name += (name.empty() ? "" : ".") + field;
    if (index > 0) name += "(" + std::to_string(index) + ")";
  }
  throw Unknown("'" + shown(name) + "' is not known" + set_hint(name));
}

Path Expression::path() {
  Path path;
  do {
    if (now().kind != TokenKind::name) throw Unknown("there is no name where one belongs");
    path.emplace_back(now().text, 0);
    ++at_;
    if (is("(")) {
      ++at_;
      const double index = single(range());
      need(")");
      if (index != std::floor(index) || index < 1 || index > most_entries) {
        throw Unknown("an index is no whole number from 1 up");
      }
      path.back().second = static_cast<int>(index);
    }
  } while (take("."));
  return path;
}

Value Expression::matrix() {
  const bool outer = in_matrix_;
  in_matrix_ = true;
  std::vector<Eigen::MatrixXd> rows;
  std::vector<Eigen::MatrixXd> row;
  std::string text;
  bool is_text = false, text_in_row = false;
  int n_rows_of_text = 0;
  const auto end_row = [&] {
    if (row.empty()) return;
    Eigen::Index cols = 0;
    for (const Eigen::MatrixXd& part : row) cols += part.cols();
    require_size(row.front().rows(), cols);
    Eigen::MatrixXd all(row.front().rows(), cols);
    Eigen::Index at = 0;
    for (const Eigen::MatrixXd& part : row) {
      if (part.rows() != all.rows()) throw Unknown("parts of a row have other numbers of rows");
      all.middleCols(at, part.cols()) = part;
      at += part.cols();
    }
    if (!rows.empty() && rows.front().cols() != cols) {
      throw Unknown("rows of a matrix are not of one length");
    }
    rows.push_back(std::move(all));
    row.clear();
  };
  while (!is("]")) {
    if (take(";")) {
      end_row();
      text_in_row = false;
    } else if (!take(",")) {
      Value value = range();
      if (value.type == Value::Type::text) {
        is_text = true;
        if (!text_in_row) ++n_rows_of_text;
        text_in_row = true;
        text += value.text;
        require_size(static_cast<Eigen::Index>(text.size()), 1);
      } else if (numbers_of(value).size() > 0) {
        row.push_back(std::move(value.numbers));
      }
    }
  }
  ++at_;
  end_row();
  in_matrix_ = outer;
  // Numbers beside a text would be letters, and texts in rows a table of letters.
  if (is_text && (!rows.empty() || n_rows_of_text > 1)) throw Unknown("a text stands in a matrix");
  if (is_text) return Value::of_text(text);
  Eigen::Index n = 0;
  for (const Eigen::MatrixXd& part : rows) n += part.rows();
  require_size(n, rows.empty() ? 0 : rows.front().cols());
  Eigen::MatrixXd all(n, rows.empty() ? 0 : rows.front().cols());
  n = 0;
  for (const Eigen::MatrixXd& part : rows) {
    all.middleRows(n, part.rows()) = part;
    n += part.rows();
  }
  return Value::of(all);
}

Value Expression::cell() {
  const bool outer = in_matrix_;
  in_matrix_ = true;
  Value value;
  value.type = Value::Type::cell;
  while (!take("}")) {
    if (!take(",") && !take(";")) value.cell.push_back(range());
  }
  in_matrix_ = outer;
  return value;
}

std::vector<Value> Expression::arguments() {
  const bool outer = in_matrix_;
  in_matrix_ = false;
  std::vector<Value> all;
  if (!take(")")) {
    do all.push_back(range());
    while (take(","));
    need(")");
  }
  in_matrix_ = outer;
  return all;
}

/// A(i), A(i, j), A(i, :) and A(:, j); the bracket is open.
Value Expression::part_of(const Eigen::MatrixXd& matrix) {
  const bool outer = in_matrix_;
  in_matrix_ = false;
  std::vector<Eigen::VectorXd> indices;
  std::vector<bool> all;
  while (!take(")")) {
    if (take(",")) continue;
    all.push_back(is(":"));
    if (all.back()) {
      ++at_;
      indices.emplace_back();
    } else {
      indices.emplace_back(numbers_of(range()).reshaped());
    }
  }
  in_matrix_ = outer;
  if (indices.size() == 1 && !all[0]) {
    Eigen::MatrixXd out(1, indices[0].size());
    for (Eigen::Index i = 0; i < out.cols(); ++i) {
      out(0, i) = matrix(index_of(indices[0](i), matrix.size()));
    }
    return Value::of(out);
  }
  if (indices.size() != 2) throw Unknown("this index is not read");
  const Eigen::Index sizes[2] = {matrix.rows(), matrix.cols()};
  std::vector<std::vector<Eigen::Index>> which(2);
  for (std::size_t k = 0; k < 2; ++k) {
    if (all[k]) {
      for (Eigen::Index i = 0; i < sizes[k]; ++i) which[k].push_back(i);
    } else {
      for (const double i : indices[k]) which[k].push_back(index_of(i, sizes[k]));
    }
  }
  require_size(static_cast<Eigen::Index>(which[0].size()),
               static_cast<Eigen::Index>(which[1].size()));
  return Value::of(Eigen::MatrixXd(matrix(which[0], which[1])));
}

}  // namespace stillframe::tools::spacar
