// Compiled without contraction (CMakeLists.txt): what is fused here is so by name, and all
// registers have the same bits.
#include "core/numerics/row_sums.hpp"

#include <algorithm>
#include <cstring>

#include "core/numerics/lanes.hpp"

namespace stillframe {

namespace {

using Eigen::Index;

[[gnu::always_inline]] inline void load(const double* from, Lanes& to) noexcept {
  std::memcpy(&to, from, sizeof to);
}

static_assert(lanes == 4 && row_chunk == 2 * lanes);

/// Of n lanes of columns; many at once, as each sum waits for its last addition.
template <Index n>
[[gnu::always_inline]] inline void combine_columns(const double* coefficients, const double* row,
                                                   Index count, Index width, double* out) noexcept {
  Lanes sum[n];
  for (Index k = 0; k < n; ++k) load(out + k * lanes, sum[k]);
  for (Index j = 0; j < count; ++j, row += width) {
    const Lanes factor = Lanes{} + coefficients[j];
    for (Index k = 0; k < n; ++k) {
      Lanes x;
      load(row + k * lanes, x);
      sum[k] += factor * x;
    }
  }
  for (Index k = 0; k < n; ++k) std::memcpy(out + k * lanes, &sum[k], sizeof sum[k]);
}

[[gnu::always_inline]] inline void combine_here(const double* coefficients, const double* rows,
                                                Index count, Index width, double* out) noexcept {
  Index column = 0;
  for (; column + 2 * row_chunk <= width; column += 2 * row_chunk) {
    combine_columns<4>(coefficients, rows + column, count, width, out + column);
  }
  if (column < width) combine_columns<2>(coefficients, rows + column, count, width, out + column);
}

/// Sums of products as if computed in twice the working precision and then rounded, a lane each.
/// Source: Ogita, Rump and Oishi, SIAM Journal on Scientific Computing 26 (2005) 1955-1988,
/// algorithm 5.3 (Dot2).
struct DoubledSums {
  Lanes sum, error{};

  [[gnu::always_inline]] void add(const Lanes& a, const Lanes& b) noexcept {
    const Lanes product = a * b;
    const Lanes product_error{
        __builtin_fma(a[0], b[0], -product[0]), __builtin_fma(a[1], b[1], -product[1]),
        __builtin_fma(a[2], b[2], -product[2]), __builtin_fma(a[3], b[3], -product[3])};
    const Lanes next = sum + product, part = next - sum;
    const Lanes sum_error = (sum - (next - part)) + (product - part);
    sum = next;
    error += product_error + sum_error;
  }
};

[[gnu::always_inline]] inline void residual_here(std::complex<double> s, Index n, Index width,
                                                 Index used, const double* A, const double* X,
                                                 const double* F, double* R) noexcept {
  const Lanes real = Lanes{} - s.real(), imaginary{s.imag(), -s.imag(), s.imag(), -s.imag()};
  for (Index i = 0; i < n; ++i) {
    for (Index column = 0; column < used; column += row_chunk) {
      DoubledSums sums[2];
      for (Index half = 0; half < 2; ++half) {
        const Index place = i * width + column + half * lanes;
        Lanes x;
        load(F + place, sums[half].sum);
        load(X + place, x);
        sums[half].add(real, x);
        sums[half].add(imaginary, Lanes{x[1], x[0], x[3], x[2]});
      }
      const double* row = X + column;
      for (Index l = 0; l < n; ++l, row += width) {
        const Lanes a = Lanes{} + A[i * n + l];
        Lanes x_0, x_1;
        load(row, x_0);
        load(row + lanes, x_1);
        sums[0].add(a, x_0);
        sums[1].add(a, x_1);
      }
      const Lanes values[2] = {sums[0].sum + sums[0].error, sums[1].sum + sums[1].error};
      const Index count = std::min(row_chunk, used - column);
      std::memcpy(R + i * width + column, values, static_cast<size_t>(count) * sizeof(double));
    }
  }
}

void combine_plain(const double* coefficients, const double* rows, Index count, Index width,
                   double* out) noexcept {
  combine_here(coefficients, rows, count, width, out);
}

void residual_plain(std::complex<double> s, Index n, Index width, Index used, const double* A,
                    const double* X, const double* F, double* R) noexcept {
  residual_here(s, n, width, used, A, X, F, R);
}

#ifdef __x86_64__
[[gnu::target("avx2,fma")]] void combine_wide(const double* coefficients, const double* rows,
                                              Index count, Index width, double* out) noexcept {
  combine_here(coefficients, rows, count, width, out);
}

/// Without the instruction each fused operation is a call.
[[gnu::target("avx2,fma")]] void residual_wide(std::complex<double> s, Index n, Index width,
                                               Index used, const double* A, const double* X,
                                               const double* F, double* R) noexcept {
  residual_here(s, n, width, used, A, X, F, R);
}

const bool is_wide = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
constexpr auto combine_wide = combine_plain;
constexpr auto residual_wide = residual_plain;
constexpr bool is_wide = false;
#endif

}  // namespace

void add_combination(const double* coefficients, const double* rows, Index count, Index width,
                     double* out) noexcept {
  (is_wide ? combine_wide : combine_plain)(coefficients, rows, count, width, out);
}

void doubled_residual(std::complex<double> s, Index n, Index width, Index used, const double* A,
                      const double* X, const double* F, double* R) noexcept {
  (is_wide ? residual_wide : residual_plain)(s, n, width, used, A, X, F, R);
}

}  // namespace stillframe
