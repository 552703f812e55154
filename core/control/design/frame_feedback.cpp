#include "core/control/design/frame_feedback.hpp"

#include <cmath>

#include "core/control/minimax_law.hpp"
#include "core/control/mode_design.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::optional<ModeLaw> mode_law(const SampledMode& mode, const ModeGoal& goal,
                                FeedbackMethod method) {
  return method == FeedbackMethod::h2 ? h2_mode_law(mode, goal) : minimax_mode_law(mode, goal).law;
}

LinearSystem put_together(const MatrixXd& in, const MatrixXd& out,
                          const std::vector<std::optional<ModeLaw>>& laws) {
  const Index m = out.rows();
  Index n = 0;
  for (const auto& law : laws) n += law->F.A.rows();
  LinearSystem whole{MatrixXd::Zero(n, n), MatrixXd::Zero(n, m), MatrixXd::Zero(m, n),
                     MatrixXd::Zero(m, m)};
  Index at = 0;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const LinearSystem& F = laws[i]->F;
    const Index k = F.A.rows(), mode = static_cast<Index>(i);
    whole.A.block(at, at, k, k) = F.A;
    whole.B.middleRows(at, k) = F.B * in.row(mode);
    whole.C.middleCols(at, k) = out.col(mode) * F.C;
    whole.D += out.col(mode) * F.D(0, 0) * in.row(mode);
    at += k;
  }
  return whole;
}

}  // namespace

FrameFeedback frame_feedback(const DesignModel& model, const std::vector<ModeTarget>& targets,
                             const Sampling& sampling, double applied_memory, ModeGoal goal,
                             FeedbackMethod method) {
  const VirtualModes modes = virtual_modes(model.legs, targets);
  const VectorXd omega = modes.squares.cast<double>().cwiseSqrt();
  const Index r = omega.size();
  FrameFeedback found{.hz = omega / two_pi, .modes = {}, .law = {}};
  bool all = true;
  const auto target_of = [&](Index i) {
    return targets[targets.size() == 1 ? 0 : static_cast<std::size_t>(i)];
  };
  for (Index i = 0; i < r; ++i) {
    const ModeTarget target = target_of(i);
    const bool as_before = i > 0 && omega(i) - omega(i - 1) < same_frequency * omega(i) &&
                           target.omega_d == target_of(i - 1).omega_d &&
                           target.zeta == target_of(i - 1).zeta;
    if (as_before) {
      found.modes.push_back(found.modes.back());
      continue;
    }
    goal.omega_d = target.omega_d;
    goal.zeta = target.zeta;
    found.modes.push_back(mode_law(SampledMode(omega(i), sampling, applied_memory), goal, method));
    all = all && found.modes.back().has_value();
  }
  if (!all) return found;
  const MatrixXd M_Phi = rounded(extended(model.legs.M) * modes.Phi);
  found.law =
      put_together((model.Q * rounded(modes.Phi)).transpose(), model.Q * M_Phi, found.modes);
  return found;
}

}  // namespace stillframe
