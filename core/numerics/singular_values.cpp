#include "core/numerics/singular_values.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "core/numerics/qd_lanes.hpp"
#include "core/numerics/qd_values.hpp"

namespace stillframe {

namespace {

using Eigen::Index;

/// Of the largest entry; squares of smaller values come near the end of what a double can hold.
constexpr double resolved = 1e-140;

/// The square of what counts as nothing beside the largest entry, about 1: of smaller squares the
/// inverse is no number.
constexpr double least_square = 1e-290;

/// The reflector v (in place of x, `count` numbers `step` apart, conjugated first if asked) and
/// 2 / v^H v, for which (I - v v^H 2 / v^H v) x has one entry that is not zero; its modulus.
/// Source: Golub and Van Loan, Matrix Computations, section 5.1.
struct Reflector {
  Lanes factor, modulus;
};

[[gnu::always_inline]] inline Reflector reflector(ComplexNumber* x, Index count,
                                                  Index step) noexcept {
  Lanes square{}, zero{};
  for (Index i = 0; i < count; ++i) {
    const ComplexNumber& a = x[i * step];
    square += a.re * a.re + a.im * a.im;
  }
  // A column that counts as nothing stands for itself: no reflection.
  square = square < least_square ? zero : square;
  Lanes modulus = square, size = x->re * x->re + x->im * x->im;
  take_root(modulus);
  take_root(size);
  const Lanes stretch = size > 0 ? modulus / size : zero;
  x->re = size > 0 ? x->re + stretch * x->re : modulus;
  x->im += stretch * x->im;
  const Lanes half = modulus * (modulus + size);
  return {half > 0 ? 1.0 / half : zero, modulus};
}

/// Columns `from` to `end` of A -= v (v^H A) factor on `count` rows; v and the top of the columns
/// given.
[[gnu::always_inline]] inline void reflect_columns(const ComplexNumber* v, const Lanes& factor,
                                                   Index count, ComplexNumber* column, Index stride,
                                                   Index n_columns) noexcept {
  for (Index j = 0; j < n_columns; ++j, column += stride) {
    Lanes re{}, im{};
    for (Index i = 0; i < count; ++i) {
      re += v[i].re * column[i].re + v[i].im * column[i].im;
      im += v[i].re * column[i].im - v[i].im * column[i].re;
    }
    re *= factor;
    im *= factor;
    for (Index i = 0; i < count; ++i) {
      column[i].re -= re * v[i].re - im * v[i].im;
      column[i].im -= re * v[i].im + im * v[i].re;
    }
  }
}

/// A -= (A v) v^H factor, with the row vector v^H given, its entries and the columns of A `stride`
/// apart; w: `count` numbers of work.
[[gnu::always_inline]] inline void reflect_rows(const ComplexNumber* row, const Lanes& factor,
                                                Index count, ComplexNumber* top, Index stride,
                                                Index n_columns, ComplexNumber* w) noexcept {
  for (Index i = 0; i < count; ++i) w[i].re = w[i].im = Lanes{};
  for (Index j = 0; j < n_columns; ++j) {
    const Lanes re = factor * row[j * stride].re, im = factor * row[j * stride].im;
    const ComplexNumber* column = top + j * stride;
    for (Index i = 0; i < count; ++i) {  // times the conjugate
      w[i].re += column[i].re * re + column[i].im * im;
      w[i].im += column[i].im * re - column[i].re * im;
    }
  }
  for (Index j = 0; j < n_columns; ++j) {
    const Lanes re = row[j * stride].re, im = row[j * stride].im;
    ComplexNumber* column = top + j * stride;
    for (Index i = 0; i < count; ++i) {
      column[i].re -= w[i].re * re - w[i].im * im;
      column[i].im -= w[i].re * im + w[i].im * re;
    }
  }
}

}  // namespace

/// Squares of the entries of the bidiagonal form, by reflections from both sides, then as many
/// values as can be had in all lanes together.
[[gnu::always_inline]] inline void SingularValues::reduce_here() noexcept {
  ComplexNumber *A = work_.data(), *w = A + m_ * n_;
  QdLanes qd;
  qd.q = scalars_.data();
  qd.e = qd.q + n_;
  qd.q_new = qd.e + n_;
  qd.e_new = qd.q_new + n_;
  qd.taken = Lanes{};
  qd.end = n_;
  for (Index k = 0; k < n_; ++k) {
    ComplexNumber* corner = A + k * m_ + k;
    const Index below = m_ - k, right = n_ - k - 1;
    const Reflector left = reflector(corner, below, 1);
    reflect_columns(corner, left.factor, below, corner + m_, m_, right);
    qd.q[k].value = left.modulus * left.modulus;
    if (right == 0) break;
    ComplexNumber* row = corner + m_;
    const Reflector across = reflector(row, right, m_);
    reflect_rows(row, across.factor, below - 1, row + 1, m_, right, w);
    qd.e[k].value = across.modulus * across.modulus;
  }
  if (n_ > 0) qd_together(qd, found_.data());
  rest_ = {qd.q, qd.e, qd.end, {qd.taken}};
}

void SingularValues::reduce_plain() noexcept { reduce_here(); }

#ifdef __x86_64__
// The same operations on wider registers, without fused ones: the same bits.
[[gnu::target("avx2")]] void SingularValues::reduce_wide() noexcept { reduce_here(); }
#else
void SingularValues::reduce_wide() noexcept { reduce_here(); }
#endif

namespace {

bool has_wide_registers() {
#ifdef __x86_64__
  return __builtin_cpu_supports("avx2");
#else
  return false;
#endif
}

}  // namespace

SingularValues::SingularValues(Index rows, Index columns)
    : m_(std::max(rows, columns)),
      n_(std::min(rows, columns)),
      transposed_(rows < columns),
      wide_(has_wide_registers()) {
  if (n_ < 0) throw std::invalid_argument("singular values: negative size");
  work_.resize(static_cast<size_t>(m_ * n_ + m_));
  scalars_.resize(static_cast<size_t>(4 * n_));
  found_.resize(static_cast<size_t>(n_));
  work_of_rest_.resize(static_cast<size_t>(5 * n_));
  sizes_.resize(static_cast<size_t>(m_));
  rows_.resize(static_cast<size_t>(m_));
  columns_.resize(static_cast<size_t>(n_));
}

/// Copies G into a lane, scaled to a largest entry of about 1, rows and columns in order of falling
/// size, so that what is small comes last. The scale; 0 if an entry is not finite.
double SingularValues::load(const Eigen::Ref<const Eigen::MatrixXcd>& G, Index lane) noexcept {
  const auto entry = [&](Index i, Index j) { return transposed_ ? G(j, i) : G(i, j); };
  const auto order = [&](std::vector<Index>& places) {
    for (size_t i = 0; i < places.size(); ++i) places[i] = static_cast<Index>(i);
    std::sort(places.begin(), places.end(), [&](Index a, Index b) {
      return sizes_[static_cast<size_t>(a)] > sizes_[static_cast<size_t>(b)];
    });
  };
  double zero = 0, largest = 0;
  for (Index j = 0; j < n_; ++j) {
    double size = 0;
    for (Index i = 0; i < m_; ++i) {
      const std::complex<double> value = entry(i, j);
      zero += 0.0 * value.real() + 0.0 * value.imag();  // NaN from an infinity or a NaN
      size = std::max({size, std::abs(value.real()), std::abs(value.imag())});
    }
    sizes_[static_cast<size_t>(j)] = size;
    largest = std::max(largest, size);
  }
  if (zero != 0.0) return 0.0;
  order(columns_);
  for (double& size : sizes_) size = 0;
  for (Index j = 0; j < n_; ++j) {
    for (Index i = 0; i < m_; ++i) {
      const std::complex<double> value = entry(i, j);
      double& size = sizes_[static_cast<size_t>(i)];
      size = std::max({size, std::abs(value.real()), std::abs(value.imag())});
    }
  }
  order(rows_);
  int exponent = 0;
  std::frexp(largest, &exponent);
  const double scale = std::ldexp(1.0, std::clamp(exponent, -1000, 1000)), inverse = 1.0 / scale;
  ComplexNumber* target = work_.data();
  for (Index j = 0; j < n_; ++j) {
    for (Index i = 0; i < m_; ++i, ++target) {
      const std::complex<double> value =
          entry(rows_[static_cast<size_t>(i)], columns_[static_cast<size_t>(j)]);
      target->re[lane] = inverse * value.real();
      target->im[lane] = inverse * value.imag();
    }
  }
  return scale;
}

void SingularValues::compute(const Eigen::MatrixXcd* G, Index count,
                             Eigen::Ref<Eigen::MatrixXd> values) noexcept {
  double scale[lanes];
  for (Index begin = 0; begin < count; begin += lanes) {
    const Index used = std::min(lanes, count - begin);
    for (Index lane = 0; lane < used; ++lane) scale[lane] = load(G[begin + lane], lane);
    wide_ ? reduce_wide() : reduce_plain();
    for (Index lane = 0; lane < used; ++lane) {
      auto out = values.col(begin + lane);
      if (scale[lane] == 0.0) {
        out.setConstant(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      finish(lane, out.data());
      // No order can be had of what is no number, nor a zero be made of it.
      if (!out.allFinite()) {
        out.setConstant(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      for (Index i = 0; i < n_; ++i) out(i) = out(i) > resolved ? out(i) : 0.0;
      std::sort(out.data(), out.data() + n_, std::greater<>());
      out *= scale[lane];
    }
  }
}

/// The values of one lane, in no order: those found in all lanes together, and the rest.
void SingularValues::finish(Index lane, double* values) noexcept {
  double *q = work_of_rest_.data(), *e = q + n_;
  for (Index i = 0; i < rest_.end; ++i) {
    q[i] = rest_.q[i].value[lane];
    if (i + 1 < rest_.end) e[i] = rest_.e[i].value[lane];
  }
  qd_values(q, e, rest_.end, rest_.taken.value[lane], e + n_, values);
  for (Index i = rest_.end; i < n_; ++i) {
    values[i] = std::sqrt(found_[static_cast<size_t>(i)].value[lane]);
  }
}

Eigen::VectorXd singular_values(const Eigen::MatrixXcd& matrix) {
  Eigen::MatrixXd values(std::min(matrix.rows(), matrix.cols()), 1);
  SingularValues(matrix.rows(), matrix.cols()).compute(&matrix, 1, values);
  return values;
}

}  // namespace stillframe
