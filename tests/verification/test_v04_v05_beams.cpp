#include <gtest/gtest.h>

#include <cmath>

#include "core/mechanics/modes.hpp"
#include "core/numerics/worst.hpp"
#include "tests/verification/closed_forms.hpp"
#include "tests/verification/convergence.hpp"
#include "tests/verification/scene_text.hpp"

// V4 and V5: natural frequencies of beams at rest.
namespace stillframe::verification {
namespace {

/// Supports and root of the characteristic equation of one of the beams. `rigid` modes at 0 Hz come
/// first.
struct BeamCase {
  std::string name, text;
  int sign, rigid, first;
};

std::vector<BeamCase> cases() {
  const std::string free = without_signals(scene_text("free_free_beam"));
  return {{"V4 cantilever", without_signals(scene_text("cantilever")), -1, 0, 1},
          {"V5 free-free", free, 1, 3, 1},
          {"V5 clamped-clamped",
           free + "supports: [{nodes: [left, right], fix: [x, y, rotation]}]\n", 1, 0, 2}};
}

/// Relative error of the k-th bending frequency (from 1). EI = 4 pi^2 in the scenes: Hz are the
/// numbers of the tables.
Error error_of(const BeamCase& beam, int k) {
  return [beam, k](int n) {
    const Eigen::VectorXd f = frequencies_hz(divided(beam.text, n));
    if (f.size() < beam.rigid + k) return 1.0;
    return f(beam.rigid + k - 1) / std::pow(beam_root(k, beam.sign), 2) - 1;
  };
}

TEST(V4V5, ClosedFormsAreThePublishedNumbers) {
  const double cantilever[] = {3.516015, 22.034492, 61.697214};
  const double clamped[] = {22.373285, 61.672823, 120.903392};
  for (int k = 1; k <= 3; ++k) {  // half a unit of the last digit
    EXPECT_NEAR(std::pow(beam_root(k, -1), 2), cantilever[k - 1], 5e-7);
    EXPECT_NEAR(std::pow(beam_root(k, 1), 2), clamped[k - 1], 5e-7);
  }
}

/// A cubic between the nodes leaves out h^4 / 720 of the square of the fourth derivative (Strang
/// and Fix, 1973), so that a frequency a^2 comes out too high by (a h)^4 / 1440, h = 1 / n. The
/// next term is smaller by a factor of the order of (a h)^2; its coefficient is below 1/6.
TEST(V4V5, FrequenciesConvergeFromAboveAsTheElementIsMadeFor) {
  for (const BeamCase& beam : cases()) {
    for (int k = 1; k <= 3; ++k) {
      const Error error = error_of(beam, k);
      const double a = beam_root(k, beam.sign);
      for (const int n : {4, 8, 16, 24}) {
        const double ah = a / n, leading = std::pow(ah, 4) / 1440;
        // Rounding: 2e-16 times the square of the highest over that of this frequency.
        const double rounding = 1e-8;
        if (ah <= 1) {
          EXPECT_NEAR(error(n), leading, leading * ah * ah / 6 + rounding)
              << beam.name << " mode " << k << ", " << n << " elements";
        }
        EXPECT_GE(error(n), -rounding) << beam.name << " mode " << k;
      }
      // The next term, up to (a h)^2 / 6 of the first with a h up to 1, shifts the order by up to
      // log2(1 / (1 - 1/6 * 3/4)) = 0.19.
      EXPECT_NEAR(observed_order(error, k < 3 ? 8 : 12), 4, 0.19) << beam.name << " mode " << k;
      print_counts(beam.name + ", mode " + std::to_string(k), error, beam.first);
    }
  }
}

TEST(V4V5, FreeBeamHasThreeRigidModes) {
  const LinearModel m = linear_model(divided(without_signals(scene_text("free_free_beam")), 8));
  const Eigen::VectorXd f = modes(m).natural_frequencies_hz;
  // Squares of zero come out as rounding of the largest square, 7300^2 Hz^2: 5e7 * 1e-15.
  EXPECT_LE(worst_of(f.head(3)), 1e-3);
  EXPECT_GT(f(3), 22);
  // The stiffness itself does not see them: translations and the rotation about the left end.
  for (int rigid = 0; rigid < 3; ++rigid) {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(m.K.rows());
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      const std::string& q = m.q_names[static_cast<size_t>(i)];
      const std::string node = q.substr(q.find('(') + 1);
      const double x = node[0] == 'r' ? 1 : node[0] == 'l' ? 0 : std::stod(node.substr(5)) / 8;
      if (rigid == 0) v(i) = q[0] == 'x';
      if (rigid == 1) v(i) = q[0] == 'y';
      if (rigid == 2) v(i) = q[0] == 'y' ? x : q[0] == 'x' ? 0 : 1;
    }
    EXPECT_LE((m.K * v).norm(), 1e-14 * m.K.norm() * v.norm()) << rigid;  // a few roundings a row
  }
}

TEST(V4V5, SecondOrderTermsChangeNothingAtRest) {
  const std::string text = divided(without_signals(scene_text("cantilever")), 6);
  const Eigen::VectorXd a = frequencies_hz(text),
                        b = frequencies_hz(with(text, "divide:", "second_order: true, divide:"));
  // The same matrices, added up in another order.
  EXPECT_LE(worst_of((a - b).cwiseQuotient(a)), 1e-9);
}

}  // namespace
}  // namespace stillframe::verification
