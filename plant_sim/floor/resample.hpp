#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace stillframe::floor {

/// up / down, in lowest terms, both positive.
struct Ratio {
  std::int64_t up, down;
};

/// The next whole number from n up that has no prime factor above 5: quick to transform.
std::int64_t next_quick_length(std::int64_t n);

/// rate_out / rate_in as a ratio of whole numbers up to `limit`, equal to 1e-12; nothing if there
/// is none.
std::optional<Ratio> rational_ratio(double rate_in, double rate_out, std::int64_t limit = 10000);

/// Fades both ends of each row of x (channels x samples) in place with half a period of a raised
/// cosine.
///   g[k] = (1 - cos(pi k / n_taper)) / 2 for k < n_taper, and mirrored at the end.
/// Errors: std::invalid_argument if the two tapers overlap.
void taper_ends(Eigen::MatrixXd& x, Eigen::Index n_taper);

/// Band-limited interpolation of each row of x (channels x n samples) to the rate of the ratio.
///   Y[b] = X[b] below both Nyquist rates, zero above: the spectrum is padded, or cut.
/// Returns channels x ((n - 1) up / down + 1) samples, the first at the instant of the first of x.
/// x is taken as zero outside its samples, so its ends should be tapered. Source: the sampling
/// theorem. Errors: std::invalid_argument if x has no samples.
Eigen::MatrixXd resample(const Eigen::MatrixXd& x, const Ratio& ratio);

}  // namespace stillframe::floor
