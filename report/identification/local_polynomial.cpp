#include "report/identification/local_polynomial.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/infinity.hpp"
#include "report/spectra/fourier.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr Index n_terms = 3;  ///< constant, slope and curvature
/// Equations beyond the unknowns that are aimed at: the noise is then known to 1 / sqrt(12) of its
/// power, and 95 % circles are 1.07 times as wide as with a known one.
constexpr Index aimed_dof = 12;
/// Fewer tell too little of the noise: with 4, circles are 1.22 times as wide as with a known one.
constexpr Index least_dof = 4;
constexpr Index least_half_width = 4;  ///< bins
/// Beyond this the inputs are one and the same to half of the digits.
constexpr double largest_condition = 1e8;
/// No parabola follows a loop over more than this to either side.
constexpr double widest_hz = 2;

Index half_width(const BroadbandPlan& plan) {
  const double segments = std::max(1.0, std::floor(plan.expected_s / plan.segment_s + 1e-9));
  const double unknowns = static_cast<double>(n_terms * plan.n_inputs + aimed_dof) / segments;
  const auto bins = static_cast<Index>(std::ceil(unknowns)) + n_terms;
  return std::max(least_half_width, bins / 2);
}

/// The triangular factor of the rows of `above`, triangular itself, and `below`.
MatrixXcd joined_factor(const MatrixXcd& above, const MatrixXcd& below) {
  MatrixXcd rows(above.rows() + below.rows(), below.cols());
  rows << above, below;
  const Index n = std::min(rows.rows(), rows.cols());
  const Eigen::HouseholderQR<MatrixXcd> qr(rows);
  return qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
}

}  // namespace

LocalPolynomial::LocalPolynomial(BroadbandPlan plan) : plan_(std::move(plan)) {
  const double rate = plan_.sample_rate_hz;
  const bool frequencies = std::all_of(plan_.frequencies_hz.begin(), plan_.frequencies_hz.end(),
                                       [rate](double f) { return f > 0 && f < 0.5 * rate; });
  if (!(rate > 0) || plan_.n_inputs < 1 || plan_.n_outputs < 1 || !(plan_.segment_s > 0) ||
      !frequencies) {
    throw std::invalid_argument(
        "LocalPolynomial: rate, inputs, outputs and segment must be positive, frequencies below "
        "half the rate");
  }
  constexpr double fewest = 2 * n_terms;
  if (!(plan_.segment_s * rate >= fewest)) {
    throw InputError(formatted("a segment of %g s holds %.3g samples at %g Hz, ", plan_.segment_s,
                               plan_.segment_s * rate, rate) +
                     formatted("%g are the fewest", fewest));
  }
  length_ = fast_length(std::llround(plan_.segment_s * rate));
  plan_.segment_s = static_cast<double>(length_) / rate;
  half_width_hz_ = (static_cast<double>(half_width(plan_)) + 0.5) / plan_.segment_s;
  segment_.resize(0, plan_.n_inputs + plan_.n_outputs);
  equations_.resize(plan_.frequencies_hz.size());
  for (Equations& e : equations_) {
    e.factor.resize(0, n_terms * plan_.n_inputs + plan_.n_outputs);
    e.power.setZero(plan_.n_outputs, plan_.n_outputs);
    e.excitation.setZero(plan_.n_inputs);
    e.filling.setZero(n_terms * plan_.n_inputs, n_terms * plan_.n_inputs);
    e.moments.setZero(n_terms, n_terms);
  }
  input_power_.setZero(plan_.n_inputs);
}

void LocalPolynomial::add(std::int64_t first_seq, const MatrixXd& inputs, const MatrixXd& outputs) {
  if (inputs.rows() != outputs.rows() || inputs.cols() != plan_.n_inputs ||
      outputs.cols() != plan_.n_outputs || finished_ || (n_rows_ > 0 && first_seq < next_seq_)) {
    throw std::invalid_argument("LocalPolynomial: rows that do not match or do not follow");
  }
  RowVectorXd row(segment_.cols());
  for (Index k = 0; k < inputs.rows(); ++k) {
    row << inputs.row(k), outputs.row(k);
    const std::int64_t seq = first_seq + k, missing = seq - next_seq_;
    if (n_rows_ > 0 && missing > 0) {
      const auto room = static_cast<std::int64_t>(length_ - n_rows_);
      if (missing > largest_filled_gap || missing >= room) {
        gap_ = true;
        take_segment();
      } else {
        const RowVectorXd before = segment_.row(n_rows_ - 1);
        gaps_.push_back({n_rows_, static_cast<Index>(missing)});
        for (std::int64_t m = 1; m <= missing; ++m) {
          append(before +
                 (row - before) * (static_cast<double>(m) / static_cast<double>(missing + 1)));
          ++n_filled_here_;
        }
      }
    }
    next_seq_ = seq + 1;
    append(row);
  }
}

void LocalPolynomial::append(const RowVectorXd& row) {
  // Not at once: a rate that is damage would ask for any memory.
  if (n_rows_ == segment_.rows()) {
    segment_.conservativeResize(std::min(length_, 2 * n_rows_ + 1024), Eigen::NoChange);
  }
  segment_.row(n_rows_++) = row;
  if (n_rows_ == length_) take_segment();
}

void LocalPolynomial::finish() {
  if (n_segments_ == 0 && n_rows_ > 0) {
    // Less has come than was expected, as of a log that was cut off: wider bins, and more of them.
    plan_.segment_s = plan_.expected_s =
        static_cast<double>(fast_length(n_rows_)) / plan_.sample_rate_hz;
    const double wider = (static_cast<double>(half_width(plan_)) + 0.5) / plan_.segment_s;
    if (wider <= widest_hz) half_width_hz_ = wider;
  }
  take_segment();
  finished_ = true;
}

MatrixXd LocalPolynomial::filling_error(Index n) const {
  // What such a line errs by over samples that are there, the nearest ones: floors have shocks.
  constexpr Index tried = 16;
  MatrixXd sum = MatrixXd::Zero(plan_.n_inputs, plan_.n_inputs);
  for (const Gap& gap : gaps_) {
    MatrixXd squares = MatrixXd::Zero(plan_.n_inputs, plan_.n_inputs);
    Index n_tried = 0;
    for (Index shift = gap.n + 1; shift <= gap.n + tried; ++shift) {
      for (const Index first : {gap.first - shift, gap.first + shift}) {
        if (first < 1 || first + gap.n >= n) continue;
        const auto rows = segment_.middleRows(first - 1, gap.n + 2).leftCols(plan_.n_inputs);
        for (Index m = 1; m <= gap.n; ++m) {
          const double share = static_cast<double>(m) / static_cast<double>(gap.n + 1);
          const RowVectorXd error =
              rows.row(m) - (1 - share) * rows.row(0) - share * rows.row(gap.n + 1);
          squares += error.transpose() * error;
        }
        ++n_tried;
      }
    }
    // The errors of one gap may all add up in a bin: gap.n times the sum of their squares at most.
    if (n_tried > 0) sum += static_cast<double>(gap.n) / static_cast<double>(n_tried) * squares;
  }
  return sum / static_cast<double>(n);
}

void LocalPolynomial::take_segment() {
  n_longest_ = std::max<std::int64_t>(n_longest_, n_rows_);
  const Index n = fast_length(n_rows_);
  const double resolution_hz = plan_.sample_rate_hz / static_cast<double>(n);
  // A segment with less than a few bins for its own transient tells nothing of T.
  const bool enough = n > 1 && std::floor(2 * half_width_hz_ / resolution_hz) >= 2 * n_terms;
  if (enough) {
    const MatrixXcd spectra = fourier(segment_.topRows(n)) / std::sqrt(static_cast<double>(n));
    // Parseval: two sides of the spectrum, in the units of its bins.
    input_power_ += 2 / static_cast<double>(n) *
                    spectra.bottomRows(spectra.rows() - 1)
                        .leftCols(plan_.n_inputs)
                        .cwiseAbs2()
                        .colwise()
                        .sum()
                        .transpose();
    const MatrixXd filling = filling_error(n);
    for (std::size_t l = 0; l < equations_.size(); ++l) {
      take(equations_[l], plan_.frequencies_hz[l], spectra, filling, resolution_hz);
    }
    ++n_segments_;
    n_filled_ += n_filled_here_;
    n_left_out_ += n_rows_ - n;
  } else {
    n_left_out_ += n_rows_ - n_filled_here_;
  }
  n_rows_ = 0;
  gaps_.clear();
  n_filled_here_ = 0;
}

void LocalPolynomial::take(Equations& equations, double frequency_hz, const MatrixXcd& spectra,
                           const MatrixXd& filling, double resolution_hz) const {
  const Index n_w = plan_.n_inputs, n_y = plan_.n_outputs;
  // Bin 0 holds the means, and no phase.
  const auto first = std::max<Index>(
      1, static_cast<Index>(std::ceil((frequency_hz - half_width_hz_) / resolution_hz)));
  const auto last = std::min<Index>(
      spectra.rows() - 2,
      static_cast<Index>(std::floor((frequency_hz + half_width_hz_) / resolution_hz)));
  const Index n = last - first + 1;
  if (n < 2 * n_terms) return;
  MatrixXcd transient(n, n_terms), rows(n, n_terms * n_w + n_y);
  for (Index k = 0; k < n; ++k) {
    // Within -1 and 1, so that all powers are of one size.
    const double x =
        (static_cast<double>(first + k) * resolution_hz - frequency_hz) / half_width_hz_;
    double power = 1;
    for (Index r = 0; r < n_terms; ++r, power *= x) {
      transient(k, r) = power;
      rows.block(k, r * n_w, 1, n_w) = power * spectra.row(first + k).head(n_w);
    }
    rows.row(k).tail(n_y) = spectra.row(first + k).tail(n_y);
  }
  const MatrixXd moments = transient.real().transpose() * transient.real();
  for (Index r = 0; r < n_terms; ++r) {
    for (Index s = 0; s < n_terms; ++s) {
      equations.filling.block(r * n_w, s * n_w, n_w, n_w) += moments(r, s) * filling;
    }
  }
  const Eigen::HouseholderQR<MatrixXcd> qr(transient);
  // What is white stays of it behind the transient, bin by bin.
  const MatrixXcd basis = qr.householderQ() * MatrixXcd::Identity(n, n_terms);
  const VectorXd left = 1 - basis.cwiseAbs2().rowwise().sum().array();
  equations.moments += transient.real().transpose() * left.asDiagonal() * transient.real();
  const MatrixXcd free = (qr.householderQ().adjoint() * rows).bottomRows(n - n_terms);
  equations.n += free.rows();
  equations.excitation += free.leftCols(n_w).cwiseAbs2().colwise().sum().transpose();
  equations.power += free.rightCols(n_y).transpose() * free.rightCols(n_y).conjugate();
  equations.factor = joined_factor(equations.factor, free);
}

Eigen::Array<bool, Eigen::Dynamic, 1> LocalPolynomial::excited(const Equations& equations) const {
  // 2 |w|^2 / rate is a density, the mean over segments of the sums over bins is taken on both
  // sides.
  const Eigen::VectorXd density =
      equations.excitation * (2 / plan_.sample_rate_hz / static_cast<double>(equations.n));
  const Eigen::VectorXd power = input_power_ / static_cast<double>(n_segments_);
  return density.array() > least_excitation * power.array();
}

bool LocalPolynomial::enough(const Equations& equations) const {
  return equations.n >= n_terms * plan_.n_inputs + least_dof;
}

std::string LocalPolynomial::at_rest(const std::vector<std::string>& inputs) const {
  std::vector<std::string> still;
  for (Index i = 0; i < plan_.n_inputs; ++i) {
    const auto moves = [&](const Equations& e) { return enough(e) && excited(e)(i); };
    if (std::any_of(equations_.begin(), equations_.end(), moves)) continue;
    still.push_back(inputs.at(static_cast<std::size_t>(i)));
  }
  if (still.empty()) return "at none of the frequencies do all inputs move";
  std::string names = "the inputs";
  if (still.size() < inputs.size()) {
    names = still.front();
    for (std::size_t i = 1; i < still.size(); ++i) names += ", " + still[i];
  }
  return names + (names == still.front() ? " does" : " do") + " not move at any of the frequencies";
}

std::string LocalPolynomial::missing(const std::vector<std::string>& inputs) const {
  const auto counts = [&](const Equations& e) { return enough(e); };
  if (std::none_of(equations_.begin(), equations_.end(), counts)) {
    BroadbandPlan one = plan_;
    one.expected_s = one.segment_s;
    const double needed_s =
        (static_cast<double>(half_width(one)) + 0.5) / std::max(widest_hz, half_width_hz_);
    const double longest_s = static_cast<double>(n_longest_) / plan_.sample_rate_hz;
    return std::string(gap_ ? "the longest stretch of the log without a gap" : "the log") +
           " has " + formatted("%.3g", longest_s) + " s, a response of " +
           std::to_string(plan_.n_inputs) + " inputs needs " + formatted("%.3g", needed_s) + " s";
  }
  const auto moved = [&](const Equations& e) { return enough(e) && excited(e).all(); };
  if (std::none_of(equations_.begin(), equations_.end(), moved)) return at_rest(inputs);
  const auto known = [&](const Equations& e) {
    return moved(e) && condition_of(e) < largest_condition;
  };
  if (std::none_of(equations_.begin(), equations_.end(), known)) {
    return "the inputs do not move independently";
  }
  const auto beside = [&](const Equations& e) {
    return known(e) && filling_share(e) < largest_filling_share;
  };
  if (std::none_of(equations_.begin(), equations_.end(), beside)) {
    return "at each of the frequencies lost samples that were filled in may take more than " +
           formatted("%g %% off the response", 100 * largest_filling_share);
  }
  return {};
}

double LocalPolynomial::condition_of(const Equations& equations) const {
  const Index p = n_terms * plan_.n_inputs;
  const MatrixXcd R = equations.factor.topLeftCorner(p, p).triangularView<Eigen::Upper>();
  const VectorXd sizes = Eigen::JacobiSVD<MatrixXcd>(R.leftCols(plan_.n_inputs)).singularValues();
  return sizes(0) / sizes(plan_.n_inputs - 1);
}

double LocalPolynomial::filling_share(const Equations& equations) const {
  const Index p = n_terms * plan_.n_inputs;
  const auto R = equations.factor.topLeftCorner(p, p).triangularView<Eigen::Upper>();
  const MatrixXcd share =
      R.solve(R.adjoint().solve(equations.filling.cast<std::complex<double>>()));
  return Eigen::JacobiSVD<MatrixXcd>(share.topRows(plan_.n_inputs)).singularValues()(0);
}

MatrixXcd LocalPolynomial::unit_noise_share(const Equations& equations) const {
  const Index n_w = plan_.n_inputs, p = n_terms * n_w;
  MatrixXcd noise = MatrixXcd::Zero(p, n_w);  // of the regressors with the inputs themselves
  for (Index r = 0; r < n_terms; ++r) {
    noise.middleRows(r * n_w, n_w).diagonal().setConstant(equations.moments(r, 0));
  }
  const auto R = equations.factor.topLeftCorner(p, p).triangularView<Eigen::Upper>();
  const MatrixXcd share = R.solve(R.adjoint().solve(noise));
  return share.topRows(n_w).transpose();
}

FrequencyResponse LocalPolynomial::estimate() const {
  if (!finished_) throw std::logic_error("LocalPolynomial: finish() comes before estimate()");
  const Index n_w = plan_.n_inputs, n_y = plan_.n_outputs, p = n_terms * n_w;
  const auto n_f = static_cast<Index>(equations_.size());
  FrequencyResponse response;
  response.frequencies_hz = plan_.frequencies_hz;
  response.dof = VectorXd::Zero(n_f);
  response.input_condition = VectorXd::Constant(n_f, infinity);
  for (Index l = 0; l < n_f; ++l) {
    const Equations& e = equations_[static_cast<std::size_t>(l)];
    const double missing = std::numeric_limits<double>::quiet_NaN();
    response.T.push_back(MatrixXcd::Constant(n_y, n_w, missing));
    response.noise.push_back(MatrixXcd::Constant(n_y, n_y, missing));
    response.input_weight.push_back(MatrixXcd::Constant(n_w, n_w, missing));
    response.unit_noise_share.push_back(MatrixXcd::Constant(n_w, n_w, missing));
    response.output_power.push_back(e.power / static_cast<double>(std::max<Index>(e.n, 1)));
    if (!enough(e) || !excited(e).all()) continue;
    const auto R = e.factor.topLeftCorner(p, p).triangularView<Eigen::Upper>();
    response.input_condition(l) = condition_of(e);
    if (!(response.input_condition(l) < largest_condition)) continue;
    if (!(filling_share(e) < largest_filling_share)) {
      response.input_condition(l) = infinity;  // as without motion
      continue;
    }
    const MatrixXcd theta = R.solve(e.factor.topRightCorner(p, n_y));
    const MatrixXcd inverse = R.solve(MatrixXcd::Identity(p, p));
    const MatrixXcd left = e.factor.bottomRightCorner(e.factor.rows() - p, n_y);
    response.dof(l) = static_cast<double>(e.n - p);
    response.T.back() = theta.topRows(n_w).transpose();
    response.noise.back() = (left.adjoint() * left).transpose() / response.dof(l);
    response.input_weight.back() = (inverse * inverse.adjoint()).topLeftCorner(n_w, n_w);
    response.unit_noise_share.back() = unit_noise_share(e);
  }
  complete(response, 2 / plan_.sample_rate_hz);
  return response;
}

}  // namespace stillframe::report
