#include "plant_sim/floor/resample.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "kissfft/kissfft.hh"

namespace stillframe::floor {

namespace {

using Complex = std::complex<double>;

/// Copies the lines of `in` that lie below both Nyquist rates; a line at the Nyquist rate of `in`
/// stands for both signs of its frequency and is halved between them, so that the old samples stay
/// what they were.
void transfer_spectrum(const std::vector<Complex>& in, std::vector<Complex>& out) {
  const std::size_t n = in.size(), m = out.size();
  out[0] = in[0];
  for (std::size_t b = 1; 2 * b < n && 2 * b < m; ++b) {
    out[b] = in[b];
    out[m - b] = in[n - b];
  }
  if (n % 2 == 0 && n <= m) {
    out[n / 2] += 0.5 * in[n / 2];
    out[m - n / 2] += 0.5 * in[n / 2];
  }
}

}  // namespace

std::int64_t next_quick_length(std::int64_t n) {
  const auto is_quick = [](std::int64_t value) {
    for (const std::int64_t factor : {2, 3, 5}) {
      while (value % factor == 0) value /= factor;
    }
    return value == 1;
  };
  n = std::max<std::int64_t>(n, 1);
  while (!is_quick(n)) ++n;
  return n;
}

std::optional<Ratio> rational_ratio(double rate_in, double rate_out, std::int64_t limit) {
  const double target = rate_out / rate_in;
  if (!(rate_in > 0.0) || !(target > 0.0) || !std::isfinite(target)) return std::nullopt;
  // Convergents of the continued fraction: the best ratios there are for their size.
  std::int64_t up = 1, down = 0, last_up = 0, last_down = 1;
  double rest = target;
  for (;;) {
    const double whole = std::floor(rest);
    if (whole > static_cast<double>(limit)) return std::nullopt;
    const auto term = static_cast<std::int64_t>(whole);
    const std::int64_t next_up = term * up + last_up, next_down = term * down + last_down;
    if (next_up > limit || next_down > limit) return std::nullopt;
    last_up = up, last_down = down, up = next_up, down = next_down;
    const double value = static_cast<double>(up) / static_cast<double>(down);
    if (up > 0 && std::abs(value - target) <= 1e-12 * target) return Ratio{up, down};
    if (rest == whole) return std::nullopt;
    rest = 1.0 / (rest - whole);
  }
}

void taper_ends(Eigen::MatrixXd& x, Eigen::Index n_taper) {
  if (n_taper < 0 || 2 * n_taper > x.cols()) {
    throw std::invalid_argument("taper_ends: expected at least " + std::to_string(2 * n_taper) +
                                " samples, got " + std::to_string(x.cols()));
  }
  for (Eigen::Index k = 0; k < n_taper; ++k) {
    const double phase = std::numbers::pi * static_cast<double>(k) / static_cast<double>(n_taper);
    const double gain = 0.5 * (1.0 - std::cos(phase));
    x.col(k) *= gain;
    x.col(x.cols() - 1 - k) *= gain;
  }
}

Eigen::MatrixXd resample(const Eigen::MatrixXd& x, const Ratio& ratio) {
  if (x.cols() == 0) throw std::invalid_argument("resample: expected samples, got none");
  if (ratio.up == ratio.down) return x;
  const std::int64_t blocks = next_quick_length((x.cols() + ratio.down - 1) / ratio.down);
  const auto n_in = static_cast<std::size_t>(blocks * ratio.down);
  const auto n_out = static_cast<std::size_t>(blocks * ratio.up);
  const kissfft<double> forward(n_in, false), backward(n_out, true);

  Eigen::MatrixXd y(x.rows(), (x.cols() - 1) * ratio.up / ratio.down + 1);
  std::vector<Complex> padded(n_in), spectrum(n_in), wide(n_out), result(n_out);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index k = 0; k < x.cols(); ++k) padded[static_cast<std::size_t>(k)] = x(i, k);
    forward.transform(padded.data(), spectrum.data());
    wide.assign(n_out, Complex(0.0, 0.0));
    transfer_spectrum(spectrum, wide);
    backward.transform(wide.data(), result.data());
    const double scale = 1.0 / static_cast<double>(n_in);
    for (Eigen::Index k = 0; k < y.cols(); ++k) {
      y(i, k) = scale * result[static_cast<std::size_t>(k)].real();
    }
  }
  return y;
}

}  // namespace stillframe::floor
