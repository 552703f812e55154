#include "core/mechanics/own_values.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <complex>
#include <limits>
#include <optional>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Entries are sums of some products of rounded numbers. Over random models up to a tenth of this
/// was seen.
constexpr double roundings = 32;

/// Up to this order of the state matrix twice the working precision takes less than a second.
constexpr Index most_extended = 64;

/// Sizes of what the entries are sums of: an entry's terms may cancel, but are no larger than those
/// on the diagonal in its row and column let them be. What nothing couples is zero.
MatrixXd bound_of(const MatrixXd& sizes) {
  const VectorXd root = sizes.diagonal().cwiseSqrt();
  return (sizes.array() > 0).select(sizes.cwiseMax(root * root.transpose()), 0.0);
}

struct Refined {
  Complex value;
  double known_to = 0;
};

/// An eigenvalue that is near s, by inverse iteration from both sides on the pencil itself, scaled
/// to a unit diagonal: so that it loses nothing beside what is stiff or fast.
class Refinement {
 public:
  explicit Refinement(const LinearModel& model) : pencil_(model), start_(model.M.rows()) {
    // A direction that is none of a model.
    for (Index i = 0; i < start_.size(); ++i) start_(i) = 1 + std::fmod(0.618 * double(i), 1.0);
  }

  Refined operator()(const Complex s_0) const {
    if (s_0 == 0.0) return {s_0, 0.0};
    Refined found{s_0, std::abs(s_0)};
    // A good start needs one step; with what is no start for anything it goes nowhere.
    for (int step = 0; step < 5; ++step) {
      Complex from = found.value;
      std::optional<Step> next = step_from(from);
      // An eigenvalue to the last bit that is known leaves nothing to divide by.
      for (double aside = 1e-14; !next && aside < 1e-2; aside *= 100) {
        from = found.value * (1 + aside);
        next = step_from(from);
      }
      if (!next) break;
      found.known_to = next->known_to;
      const Complex value = from + next->change;
      if (std::abs(value - s_0) > 0.5 * std::abs(s_0)) {
        return {s_0, std::max(found.known_to, std::abs(value - s_0))};
      }
      const double change = std::abs(value - found.value);
      if (change <= next->known_to) break;
      found = {value, std::max(next->known_to, change)};
    }
    return found;
  }

 private:
  struct Step {
    Complex change;
    double known_to = 0;
  };

  std::optional<Step> step_from(Complex s) const {
    const double modulus = std::abs(s);
    const VectorXd diagonal =
        modulus * (modulus * pencil_.M_size.diagonal() + pencil_.C_size.diagonal()) +
        pencil_.K_size.diagonal();
    const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
    const MatrixXcd P = s * (s * pencil_.M + pencil_.C) + pencil_.K;
    const Eigen::PartialPivLU<MatrixXcd> factors(scale.asDiagonal() * P * scale.asDiagonal());
    const VectorXcd right = factors.solve(start_.cast<Complex>()).normalized();
    const VectorXcd left = factors.transpose().solve(start_.cast<Complex>()).normalized();
    const VectorXcd v = scale.asDiagonal() * VectorXcd(factors.solve(right));
    const VectorXcd w = scale.asDiagonal() * VectorXcd(factors.transpose().solve(left));
    if (!v.allFinite() || !w.allFinite()) return std::nullopt;
    // w^T P v without the cancellation: P v is what was solved for.
    const Complex P_wv = w.cwiseProduct(VectorXcd(scale.cwiseInverse().asDiagonal() * right)).sum();
    const Complex slope =
        w.cwiseProduct(VectorXcd(2.0 * s * (pencil_.M * v) + pencil_.C * v)).sum();
    const Step step{-P_wv / slope, pencil_.known_to(s, v, w)};
    if (!std::isfinite(std::abs(step.change))) return std::nullopt;
    return step;
  }

  EigenvalueRounding pencil_;
  VectorXd start_;
};

std::optional<VectorXcd> extended_eigenvalues(const LinearModel& model) {
  const auto L = cholesky_factor(extended(model.M));
  if (!L) return std::nullopt;
  const Index n = model.M.rows();
  const auto rows = [&](const ExtendedMatrix& B) -> ExtendedMatrix {
    return -backward_solve(*L, forward_solve(*L, B));
  };
  ExtendedMatrix A = ExtendedMatrix::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = rows(extended(model.K) + extended(model.N) + extended(model.G));
  A.bottomRightCorner(n, n) = rows(extended(model.C) + extended(model.D));
  const MatrixXd A_rounded = rounded(A);
  if (!A_rounded.allFinite()) return std::nullopt;
  const ExtendedVector S = balancing_scales(A_rounded).cast<DoubleDouble>();
  const ExtendedVector S_inverse = balancing_scales(A_rounded).cwiseInverse().cast<DoubleDouble>();
  try {
    const VectorXcd values =
        eigenvalues(ExtendedMatrix(S_inverse.asDiagonal() * A * S.asDiagonal()));
    if (values.allFinite()) return values;
  } catch (const std::runtime_error&) {
  }
  return std::nullopt;
}

VectorXcd sorted(const VectorXcd& values) {
  std::vector<Complex> real;
  std::vector<std::pair<Complex, Complex>> pairs;
  for (const Complex& value : values) {
    if (value.imag() == 0) real.push_back(value);
    if (value.imag() > 0) pairs.emplace_back(value, std::conj(value));
  }
  const auto smaller = [](const Complex& a, const Complex& b) { return std::abs(a) < std::abs(b); };
  std::stable_sort(real.begin(), real.end(), smaller);
  for (size_t i = 0; i + 1 < real.size(); i += 2) pairs.emplace_back(real[i], real[i + 1]);
  std::stable_sort(pairs.begin(), pairs.end(),
                   [&](const auto& a, const auto& b) { return smaller(a.first, b.first); });
  VectorXcd all(values.size());
  Index next = 0;
  for (const auto& [one, other] : pairs) {
    all(next++) = one;
    all(next++) = other;
  }
  return all;
}

/// What is asked of the eigenvalues: which are zero, or which of them grow as well.
enum class Asked { zeros, growth };

/// Whether the state matrix alone may leave open what is asked. Of many dofs the others, that are
/// not slow beside the fastest one, are what they are.
bool in_doubt(Complex s, double largest, Asked asked) {
  return std::abs(s) < 1e-4 * largest || (asked == Asked::growth && s.real() > 0);
}

OwnValues own_values(const LinearModel& model, Asked asked) {
  mass_factors(model);  // refuses
  const bool few = 2 * model.M.rows() <= most_extended;
  std::optional<VectorXcd> found;
  if (few) found = extended_eigenvalues(model);
  if (!found) found = eigenvalues(state_matrix(model));
  if (!found) {
    throw Refusal(
        "the eigenvalues of the state matrix cannot be computed: it is not finite, or its entries "
        "are too far apart; look for a stiffness, mass or damping with a wrong power of ten");
  }
  const Refinement refined(model);
  const double largest = found->size() > 0 ? found->cwiseAbs().maxCoeff() : 0.0;
  OwnValues own{sorted(*found), VectorXd::Constant(found->size(), 1e-10 * largest)};
  for (Index i = 0; i < own.values.size(); ++i) {
    const Complex s = own.values(i);
    if (s.imag() < 0) {
      own.values(i) = std::conj(own.values(i - 1));
      own.known_to(i) = own.known_to(i - 1);
    } else if (few || in_doubt(s, largest, asked)) {
      const Refined better = refined(s);
      own.values(i) = better.value;
      own.known_to(i) = better.known_to;
    }
  }
  return own;
}

}  // namespace

EigenvalueRounding::EigenvalueRounding(const LinearModel& model)
    : M(model.M),
      C(model.damping()),
      K(model.stiffness()),
      M_size(bound_of(model.M.cwiseAbs())),
      C_size(bound_of(model.C.cwiseAbs() + model.D.cwiseAbs())),
      K_size(bound_of(model.K.cwiseAbs() + model.N.cwiseAbs() + model.G.cwiseAbs())) {
  const VectorXd squares = K_size.diagonal().cwiseQuotient(M_size.diagonal());
  if (squares.size() > 0) fastest_ = std::sqrt(squares.maxCoeff());
}

double EigenvalueRounding::known_to(Complex s, const VectorXcd& v, const VectorXcd& w) const {
  const double modulus = std::abs(s);
  const VectorXd v_size = v.cwiseAbs(), w_size = w.cwiseAbs();
  const VectorXd P_v = modulus * (modulus * (M_size * v_size) + C_size * v_size) + K_size * v_size;
  const double change = roundings * epsilon * w_size.dot(P_v);
  // w^T P v moved by so much: a t^2 + b t = change. Of two that meet b is zero.
  const VectorXcd M_v = M * v, C_v = C * v;
  const double a = std::abs(w.cwiseProduct(M_v).sum());
  const double b = std::abs(w.cwiseProduct(2.0 * s * M_v + C_v).sum());
  const double known = change > 0 ? 2 * change / (b + std::sqrt(b * b + 4 * a * change)) : 0.0;
  return std::max(known, epsilon * fastest_);
}

OwnValues own_values(const LinearModel& model) { return own_values(model, Asked::growth); }

VectorXd own_frequencies_hz(const LinearModel& model) {
  std::vector<double> found;
  try {
    const OwnValues own = own_values(model, Asked::zeros);
    for (Index i = 0; i < own.values.size(); ++i) {
      if (own.values(i).imag() < 0 || own.is_zero(i)) continue;
      found.push_back(std::abs(own.values(i)) / two_pi);
    }
  } catch (const Refusal&) {
    return {};
  }
  std::sort(found.begin(), found.end());
  return Eigen::Map<VectorXd>(found.data(), static_cast<Index>(found.size()));
}

}  // namespace stillframe
