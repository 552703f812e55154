#include "core/control/discrete_law.hpp"

#include <cmath>

#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Linear prediction from two samples, (1 + a) e[k] - a e[k-1]: what e will be a samples later, up
// to its curvature.
LinearSystem lead(double samples, Index m) {
  const MatrixXd I = MatrixXd::Identity(m, m);
  return {.A = MatrixXd::Zero(m, m), .B = I, .C = -samples * I, .D = (1 + samples) * I};
}

}  // namespace

DiscreteLaw sample_law(ForceFeedback feedback, const LawSampling& sampling) {
  const bool implicit = sampling.realisation == Realisation::implicit_feedthrough;
  feedback.lead = 0;
  LinearSystem law = tustin(implicit ? strain_feedback(feedback) : stress_feedback(feedback),
                            sampling.sample_time);
  if (sampling.lead_samples > 0) {
    law = in_series(lead(sampling.lead_samples, feedback.K_P.rows()), law);
  }
  const double corner = two_pi * sampling.sensor_filter_hz;
  return {.A = law.A,
          .B = law.B,
          .C = law.C,
          .D = law.D,
          .subtract_applied = implicit,
          .applied_memory = implicit && corner > 0 ? std::exp(-corner * sampling.sample_time) : 0};
}

}  // namespace stillframe
