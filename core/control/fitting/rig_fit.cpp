#include "core/control/fitting/rig_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "core/control/fitting/rig_model.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/infinity.hpp"
#include "core/yaml/loop_numbers.hpp"

namespace stillframe::fitting {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = robustness::Parameter::Kind;

namespace {

constexpr int most_steps = 40;
/// How the fit looks at the record, one look after the other.
struct Look {
  /// Modes that look damped by a tenth pass through lines, and so to where they are.
  double decay;
  double wrong;  ///< the part of what is read that the model is taken to be wrong by
};
constexpr Look looks[] = {{0.1, 0.3}, {0.02, 0.1}, {0, 0.03}, {0, 0}, {0, 0}};
constexpr int most_rounds = std::size(looks), first_by_noise = 3;
// Of a prior's standard deviation: of the 1e-10 of a model's matrices, 1e-7 of a slope is left.
constexpr double difference_step = 1e-3;
// A twentieth of a standard deviation, squared: not seen in any band. Where there is no noise yet
// to measure by, a part of what is left.
constexpr double still = 0.0025, small_part = 1e-3;
// Of what a mass, a stiffness or a gain is in the scene.
constexpr double least_part = 0.05;
// Of the size of an output at a line: what converters and arithmetic leave of a simulation.
constexpr double least_noise = 1e-7;

/// The step of a converter, from what it read; 0 where steps are not seen.
double step_of(const Eigen::Ref<const VectorXd>& values) {
  std::vector<double> distinct(values.begin(), values.end());
  std::ranges::sort(distinct);
  const auto end = std::unique(distinct.begin(), distinct.end());
  distinct.erase(end, distinct.end());
  const std::size_t n = distinct.size();
  if (n < 2 || 2 * n > static_cast<std::size_t>(values.size())) return 0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < n; ++i) steps.push_back(distinct[i] - distinct[i - 1]);
  // Lost samples on straight lines have values between the steps, a few.
  std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
  return steps[steps.size() / 2];
}

/// L_l of each line, n_out x n_out.
using Weights = std::vector<MatrixXcd>;

/// Columns whose unknown factors are eliminated.
struct Nuisance {
  explicit Nuisance(const MatrixXd& columns)
      : norms(columns.colwise().norm().cwiseMax(1e-300).transpose()),
        qr(columns * norms.cwiseInverse().asDiagonal()) {}
  VectorXd solve(const VectorXd& values) const {
    return norms.cwiseInverse().asDiagonal() * qr.solve(values);
  }

  VectorXd norms;
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
};

/// Sum over windows of what least squares ask for, the ends of the windows eliminated.
struct Normal {
  double cost = 0, driven = 0;  ///< of all windows, and of the driven: a real number in the mean
  MatrixXd JtJ;
  VectorXd Jtr;
  std::vector<MatrixXcd> residual;  ///< of each window, n_out x lines, not weighted
  std::vector<double> each;         ///< of each window, a real number in the mean
};

class Fit {
 public:
  Fit(const FitQuestion& question, const RigRecord& record, const std::vector<bool>& driven)
      : question_(question), record_(record), driven_(driven) {
    look_from(0);
    const auto m = record.command.cols();
    rounding_.resize(n_out());
    for (Index i = 0; i < rounding_.size(); ++i) {
      const double step = step_of(i < m       ? record.sigma.col(i)
                                  : i < 2 * m ? record.applied.col(i - m)
                                              : record.frame.col(i - 2 * m));
      // Of sensor and amplifier each a twelfth of the squared step, 2/n times a sum of n; half of
      // it is in the real part. At rest there is none of it.
      rounding_(i) = step * step / (3 * static_cast<double>(record.n_window));
    }
  }

  /// Sums at lines beyond the circle by that decay.
  void look_from(double decay) {
    kernel_.emplace(record_.n_window, record_.lines, decay);
    windows_.clear();
    const int age = question_.sampling.instruments.report_age_samples;
    for (std::size_t w = 0; w < record_.windows.size(); ++w) {
      windows_.emplace_back(record_, static_cast<Index>(w), age, *kernel_);
    }
  }

  /// What is applied when sigma is sampled jumps where the delay goes through a whole number of
  /// samples: the fit stays between those two between which the scene as it is leaves least, and
  /// begins where it does.
  void choose_whole_delay(VectorXd& values, const Weights& weights) {
    for (Index i = 0; i < p(); ++i) {
      if (question_.parameters[static_cast<std::size_t>(i)].kind == Kind::delay) delay_ = i;
    }
    if (delay_ < 0) return;
    const double nominal = question_.sampling.delay_samples,
                 size = question_.parameters[static_cast<std::size_t>(delay_)].size;
    double least = infinity;
    // As far as is looked: of its size, and of what a scene may have.
    const double to = std::min(nominal + 2 * size, double{longest_delay_samples});
    for (double whole = std::floor(std::max(0.0, nominal - 2 * size)); whole <= to; ++whole) {
      for (const double part : {0.0, 0.2, 0.4, 0.6, 0.8, 0.97}) {
        VectorXd at = values;
        at(delay_) = (whole + part - nominal) / size;
        const double cost = normal(at, weights, false).cost + at.squaredNorm();
        if (!(cost < least)) continue;
        least = cost;
        values = at;
        first_ = (whole - nominal) / size;
        last_ = (whole + 1 - 1e-9 - nominal) / size;
      }
    }
  }
  void keep_place(VectorXd& values) const {
    if (delay_ >= 0) values(delay_) = std::clamp(values(delay_), first_, last_);
  }
  /// The delay where it stands at an end of its place and would go beyond; -1: nothing does.
  Index held(const VectorXd& values, const VectorXd& downhill) const {
    if (delay_ < 0) return -1;
    const bool below = values(delay_) <= first_ && downhill(delay_) < 0,
               above = values(delay_) >= last_ && downhill(delay_) > 0;
    return below || above ? delay_ : -1;
  }
  /// Whether there is such a thing: masses, stiffnesses and gains are above zero.
  bool has_place(const VectorXd& values) const {
    for (Index i = 0; i < p(); ++i) {
      const auto& parameter = question_.parameters[static_cast<std::size_t>(i)];
      switch (parameter.kind) {
        case Kind::centre_of_mass:
        case Kind::leg_direction:
        case Kind::delay:
          break;
        default:
          if (!(1 + parameter.size * values(i) > least_part)) return false;
      }
    }
    return true;
  }

  Index n_out() const { return windows_.front().read().rows(); }
  Index n_lines() const { return windows_.front().read().cols(); }
  Index p() const { return static_cast<Index>(question_.parameters.size()); }

  SampledPlant plant(const VectorXd& values) const {
    return robustness::sampled(
        robustness::perturbed(question_.scene, question_.sampling, question_.parameters, values));
  }
  RigModel model(const VectorXd& values) const {
    return RigModel(plant(values), record_, question_.frame, *kernel_);
  }

  /// Outputs by their size at each line: of nothing known yet.
  Weights by_size() const {
    Weights weights;
    const auto read = all_read();
    for (Index l = 0; l < n_lines(); ++l) {
      weights.push_back(rms(read, l).cwiseInverse().asDiagonal());
    }
    return weights;
  }

  /// The inverse roots of the covariance of what is left about each line, of the windows at rest or
  /// of all; with a part of the size of each output, by which the model may still be wrong.
  Weights by_noise(const std::vector<MatrixXcd>& residual, Index n_ends, bool of_all,
                   double wrong) const {
    std::vector<MatrixXcd> noise;
    for (std::size_t w = 0; w < residual.size(); ++w) {
      if (of_all || !driven_[w]) noise.push_back(residual[w]);
    }
    const auto n_windows = static_cast<Index>(noise.size());
    // So many lines that there are three times as many numbers as the covariance has dimensions.
    const Index about = std::max<Index>(1, (3 * n_out() + n_windows - 1) / n_windows / 2);
    // The ends of a window take up a part of what it reads.
    const double left =
        1 - static_cast<double>(n_ends) / static_cast<double>(2 * n_lines() * n_out());
    const auto read = all_read();
    std::vector<VectorXd> size;
    for (Index l = 0; l < n_lines(); ++l) size.push_back(rms(noise, l));
    Weights weights;
    for (Index l = 0; l < n_lines(); ++l) {
      const Index from = std::max<Index>(0, l - about), to = std::min(n_lines() - 1, l + about);
      const VectorXd& here = size[static_cast<std::size_t>(l)];
      MatrixXcd S = MatrixXcd::Zero(n_out(), n_out());
      Index n = 0;
      for (Index near = from; near <= to; ++near) {
        // Noise grows by orders from line to line.
        const VectorXd scale = here.cwiseQuotient(size[static_cast<std::size_t>(near)]);
        for (const MatrixXcd& of_window : noise) {
          const Eigen::VectorXcd r = scale.cwiseProduct(of_window.col(near));
          S += r * r.adjoint();
          ++n;
        }
      }
      // The inverse of a covariance that was found from n vectors is too large by this.
      const double few = static_cast<double>(n) / std::max<double>(1, double(n - n_out()));
      // Half of it is in the real part, and least squares are over real and imaginary parts.
      S *= few / (2 * static_cast<double>(n) * left);
      S.diagonal() += ((least_noise + wrong) * rms(read, l)).cwiseAbs2().cast<Complex>();
      S.diagonal() += rounding_.cast<Complex>();
      const Eigen::LLT<MatrixXcd> llt(S);
      weights.push_back(llt.matrixL().solve(MatrixXcd::Identity(n_out(), n_out())));
    }
    return weights;
  }

  Normal normal(const VectorXd& values, const Weights& weights, bool with_slopes) const {
    const RigModel at = model(values);
    std::vector<RigModel> slopes;
    for (Index i = 0; with_slopes && i < p(); ++i) {
      VectorXd above = values, below = values;
      above(i) += difference_step;
      below(i) -= difference_step;
      if (i == delay_) {
        above(i) = std::min(above(i), last_);
        below(i) = std::max(below(i), first_);
      }
      slopes.push_back(at.slope(plant(above), plant(below), above(i) - below(i)));
    }
    const Index n = at.n_ends(), rows = 2 * n_lines() * n_out(), n_slopes = with_slopes ? p() : 0;
    // The ends are the same columns in every window.
    const auto ends_of = [&](const RigModel& of) {
      MatrixXd columns(rows, n);
      for (Index l = 0; l < n_lines(); ++l) {
        const auto k = static_cast<std::size_t>(l);
        put(weights[k] * of.of_ends(k), l, columns);
      }
      return columns;
    };
    const MatrixXd ends = ends_of(at);
    std::vector<MatrixXd> ends_slope;
    for (Index i = 0; i < n_slopes; ++i) {
      const auto k = static_cast<std::size_t>(i);
      ends_slope.push_back(ends_of(slopes[k]));
    }
    const Nuisance ends_only(ends);
    Normal sum;
    sum.JtJ = MatrixXd::Zero(n_slopes, n_slopes);
    sum.Jtr = VectorXd::Zero(n_slopes);
    Index n_driven = 0;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      const WindowData& window = windows_[w];
      MatrixXd all(rows, 1 + n_slopes);
      put(window.read() - at.predicted(window), weights, 0, all);
      // Numbers that did not come are unknown as well, in this window alone.
      std::optional<Nuisance> with_gaps;
      if (const auto gaps = window.gaps(); !gaps.empty()) {
        MatrixXd columns(rows, n + static_cast<Index>(gaps.size()));
        columns.leftCols(n) = ends;
        for (std::size_t i = 0; i < gaps.size(); ++i) {
          put(gaps[i], weights, n + static_cast<Index>(i), columns);
        }
        with_gaps.emplace(columns);
      }
      const Nuisance& nuisance = with_gaps ? *with_gaps : ends_only;
      const Index rank = nuisance.qr.rank();
      // Who rings where a window begins rings on in another way in another plant.
      const VectorXd D = nuisance.solve(all.col(0)).head(n);
      for (Index i = 0; i < n_slopes; ++i) {
        const auto k = static_cast<std::size_t>(i);
        put(slopes[k].predicted(window), weights, 1 + i, all);
        all.col(1 + i) += ends_slope[k] * D;
      }
      all.applyOnTheLeft(nuisance.qr.householderQ().adjoint());
      all.topRows(rank).setZero();
      sum.cost += all.col(0).squaredNorm();
      sum.each.push_back(all.col(0).squaredNorm() /
                         static_cast<double>(std::max<Index>(1, rows - rank)));
      if (driven_[w]) {
        sum.driven += all.col(0).squaredNorm();
        n_driven += rows - rank;
      }
      sum.JtJ.noalias() += all.rightCols(n_slopes).transpose() * all.rightCols(n_slopes);
      sum.Jtr.noalias() += all.rightCols(n_slopes).transpose() * all.col(0);
      // What is left, without its weight.
      all.applyOnTheLeft(nuisance.qr.householderQ());
      sum.residual.push_back(taken(all.col(0), weights));
    }
    sum.driven /= static_cast<double>(std::max<Index>(1, n_driven));
    return sum;
  }

  /// Of each output, rms over driven windows and lines of what is left over what was read.
  VectorXd left(const std::vector<MatrixXcd>& residual) const {
    VectorXd sum = VectorXd::Zero(n_out()), read = sum;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      if (!driven_[w]) continue;
      sum += residual[w].rowwise().squaredNorm();
      read += windows_[w].read().rowwise().squaredNorm();
    }
    return sum.cwiseQuotient(read.cwiseMax(1e-300)).cwiseSqrt();
  }
  /// Of each leg, from what a fit leaves.
  std::vector<LegResponse> responses(const VectorXd& values,
                                     const std::vector<MatrixXcd>& residual) const {
    const RigModel fitted = model(values), before = model(VectorXd::Zero(p()));
    const auto m = record_.command.cols();
    std::vector<LegResponse> legs(static_cast<std::size_t>(m));
    std::vector<double> n(legs.size(), 0);
    const Eigen::VectorXi at_once = Eigen::VectorXi::Zero(m);
    for (LegResponse& leg : legs) {
      leg.measured = leg.fitted = leg.before = Eigen::VectorXcd::Zero(n_lines());
    }
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      if (!driven_[w]) continue;
      const MatrixXcd command = windows_[w].driven(at_once).middleRows(m, m);
      Index i = 0;
      command.rowwise().squaredNorm().maxCoeff(&i);
      const auto over = [&](const MatrixXcd& all) {
        return all.row(i).cwiseQuotient(command.row(i)).transpose().eval();
      };
      const MatrixXcd predicted = fitted.predicted(windows_[w]);
      LegResponse& leg = legs[static_cast<std::size_t>(i)];
      leg.measured += over(predicted + residual[w]);
      leg.fitted += over(predicted);
      leg.before += over(before.predicted(windows_[w]));
      n[static_cast<std::size_t>(i)] += 1;
    }
    for (std::size_t i = 0; i < legs.size(); ++i) {
      for (Eigen::VectorXcd* sum : {&legs[i].measured, &legs[i].fitted, &legs[i].before}) {
        *sum /= std::max(1.0, n[i]);
      }
    }
    return legs;
  }
  bool has_rest() const { return std::ranges::find(driven_, false) != driven_.end(); }

 private:
  std::vector<MatrixXcd> all_read() const {
    std::vector<MatrixXcd> read;
    for (const WindowData& window : windows_) read.push_back(window.read());
    return read;
  }
  /// Over windows, never zero.
  VectorXd rms(const std::vector<MatrixXcd>& windows, Index line) const {
    VectorXd sum = VectorXd::Zero(n_out());
    for (const MatrixXcd& window : windows) sum += window.col(line).cwiseAbs2();
    sum = (sum / static_cast<double>(windows.size())).cwiseSqrt();
    return sum.cwiseMax(1e-12 * std::max(sum.maxCoeff(), 1e-300));
  }
  /// Complex columns as real ones, real parts above imaginary, at the place of a line.
  void put(const MatrixXcd& columns, Index line, MatrixXd& all) const {
    const Index at = 2 * line * n_out();
    all.middleRows(at, n_out()).leftCols(columns.cols()) = columns.real();
    all.middleRows(at + n_out(), n_out()).leftCols(columns.cols()) = columns.imag();
  }
  /// n_out x lines, weighted, as one column.
  void put(const MatrixXcd& of_lines, const Weights& weights, Index column, MatrixXd& all) const {
    for (Index l = 0; l < n_lines(); ++l) {
      const Eigen::VectorXcd w = weights[static_cast<std::size_t>(l)] * of_lines.col(l);
      all.col(column).segment(2 * l * n_out(), n_out()) = w.real();
      all.col(column).segment((2 * l + 1) * n_out(), n_out()) = w.imag();
    }
  }
  /// The way back; weights are lower triangles.
  MatrixXcd taken(const VectorXd& column, const Weights& weights) const {
    MatrixXcd all(n_out(), n_lines());
    for (Index l = 0; l < n_lines(); ++l) {
      Eigen::VectorXcd w(n_out());
      w.real() = column.segment(2 * l * n_out(), n_out());
      w.imag() = column.segment((2 * l + 1) * n_out(), n_out());
      all.col(l) = weights[static_cast<std::size_t>(l)].triangularView<Eigen::Lower>().solve(w);
    }
    return all;
  }

  const FitQuestion& question_;
  const RigRecord& record_;
  const std::vector<bool>& driven_;
  std::optional<LineKernel> kernel_;
  std::vector<WindowData> windows_;
  VectorXd rounding_;            ///< n_out, what steps of converters add to the noise
  Index delay_ = -1;             ///< parameter
  double first_ = 0, last_ = 0;  ///< values that it is kept between
};

/// The windows that are left without those in which far more is left than in most, empty if that
/// is not a few.
std::vector<std::size_t> without_outliers(const std::vector<double>& each) {
  constexpr double far = 3, few = 0.25;
  std::vector<double> sorted = each;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const double middle = sorted[sorted.size() / 2];
  std::vector<std::size_t> left;
  for (std::size_t w = 0; w < each.size(); ++w) {
    if (each[w] < far * std::max(middle, 1.0)) left.push_back(w);
  }
  const auto n_out = static_cast<double>(each.size() - left.size());
  if (n_out == 0 || n_out > few * static_cast<double>(each.size())) left.clear();
  return left;
}

/// Where a model has no place: masses and stiffnesses below zero, say.
double cost_at(const Fit& fit, const VectorXd& values, const Weights& weights) {
  try {
    if (fit.has_place(values))
      return fit.normal(values, weights, false).cost + values.squaredNorm();
  } catch (const Refusal&) {
  } catch (const InputError&) {
  }
  return infinity;
}

RigFit fit_all(const FitQuestion& question, const RigRecord& record,
               const std::vector<bool>& driven, const std::function<void(double)>& progress,
               std::vector<double>& each) {
  if (record.windows.size() < 2 || driven.size() != record.windows.size()) {
    throw std::invalid_argument("fit_rig: there have to be two windows or more");
  }
  Fit fit(question, record, driven);
  const Index p = fit.p();
  RigFit found;
  found.values = VectorXd::Zero(p);
  Weights weights = fit.by_size();
  found.left_before = fit.left(fit.normal(found.values, weights, false).residual);
  const auto look = [&](int round, const std::vector<MatrixXcd>& residual, bool of_all) {
    weights = fit.by_noise(residual, fit.model(found.values).n_ends(), of_all, looks[round].wrong);
  };
  fit.look_from(looks[0].decay);
  look(0, fit.normal(found.values, fit.by_size(), false).residual, !fit.has_rest());
  fit.choose_whole_delay(found.values, weights);
  Normal now = fit.normal(found.values, weights, true);
  // By the noise at rest, which no error of the model is in, at last by all that is left, if that
  // is noise.
  for (int round = 0; round < most_rounds; ++round) {
    double damp = 1e-3;
    found.converged = false;
    for (int step = 0; step < most_steps && !found.converged; ++step) {
      ++found.n_iterations;
      MatrixXd A = now.JtJ;
      A.diagonal().array() += 1;
      VectorXd b = now.Jtr - found.values;
      if (const Index held = fit.held(found.values, b); held >= 0) {
        A.row(held).setZero();
        A.col(held).setZero();
        A(held, held) = 1;
        b(held) = 0;
      }
      const double cost = now.cost + found.values.squaredNorm();
      // What an undamped step would win. By noise it is a square of standard deviations.
      found.converged =
          b.dot(A.ldlt().solve(b)) < (round < first_by_noise ? small_part * cost : still);
      if (found.converged) break;
      VectorXd there = found.values;
      bool better = false;
      for (int attempt = 0; attempt < 14 && !better; ++attempt) {
        MatrixXd damped = A;
        damped.diagonal() *= 1 + damp;
        VectorXd change = damped.ldlt().solve(b);
        // Beyond its own size a parameter is taken a part of the way.
        change *= std::min(1.0, 1 / std::max(change.lpNorm<Eigen::Infinity>(), 1e-300));
        there = found.values + change;
        fit.keep_place(there);
        better = cost_at(fit, there, weights) < cost;
        damp = std::clamp(better ? damp / 10 : damp * 10, 1e-9, 1e9);
      }
      if (!better) break;
      found.values = there;
      now = fit.normal(found.values, weights, true);
      if (progress) progress((round + step / double(most_steps)) / most_rounds);
    }
    found.left = fit.left(now.residual);
    if (round == first_by_noise && fit.has_rest()) {
      found.over_noise = now.driven;
      each = now.each;
    }
    if (round + 1 == most_rounds || (round + 2 == most_rounds && !found.is_noise())) break;
    if (looks[round + 1].decay != looks[round].decay) {
      fit.look_from(looks[round + 1].decay);
      now = fit.normal(found.values, fit.by_size(), false);
    }
    look(round + 1, now.residual, !fit.has_rest() || round + 2 == most_rounds);
    now = fit.normal(found.values, weights, true);
  }
  MatrixXd A = now.JtJ;
  A.diagonal().array() += 1;
  found.legs = fit.responses(found.values, now.residual);
  found.covariance = A.ldlt().solve(MatrixXd::Identity(p, p));
  return found;
}

}  // namespace

RigFit fit_rig(const FitQuestion& question, const RigRecord& record,
               const std::vector<bool>& driven, const std::function<void(double)>& progress) {
  std::vector<double> each;
  RigFit found = fit_all(question, record, driven, progress, each);
  if (found.is_noise() || each.empty()) return found;
  const std::vector<std::size_t> left = without_outliers(each);
  if (left.empty()) return found;
  RigRecord rest = record;
  std::vector<bool> rest_driven;
  rest.windows.clear();
  for (const std::size_t w : left) {
    rest.windows.push_back(record.windows[w]);
    rest_driven.push_back(driven[w]);
  }
  found = fit_all(question, rest, rest_driven, progress, each);
  found.n_left_out = static_cast<int>(record.windows.size() - left.size());
  return found;
}

}  // namespace stillframe::fitting
