#include "tests/fuzz/decay.hpp"

#include <cmath>

#include "controller/law.hpp"
#include "core/numerics/balance.hpp"

namespace stillframe::fuzz {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Plant, law and all that is under way, one sample at a time.
class Simulation {
 public:
  explicit Simulation(const controller::Gains& gains)
      : plant_(sample_and_hold(gains.feedback_plant(), gains.sampling())),
        law_(controller::law_from_gains(gains)),
        n_(plant_.Phi.rows()),
        m_(gains.n_legs()),
        n_law_(law_.A.rows()),
        delay_(plant_.whole_delay(0)) {}

  /// States, law, the command that held before, the filtered report, reports and commands under
  /// way.
  Index size() const { return n_ + n_law_ + m_ * (2 + plant_.report_age + delay_); }

  /// One step from each of the columns.
  MatrixXd step(const MatrixXd& S) const {
    const Index law = n_, held = law + n_law_, filtered = held + m_, reports = filtered + m_;
    const Index pending = reports + m_ * plant_.report_age;
    const auto x = S.topRows(n_), x_law = S.middleRows(law, n_law_), c_0 = S.middleRows(held, m_);
    const MatrixXd report = plant_.C_report * x + plant_.D_report * c_0;
    const MatrixXd heard = plant_.report_age > 0 ? MatrixXd(S.middleRows(reports, m_)) : report;
    const double memory = law_.applied_memory;
    const MatrixXd r = memory * S.middleRows(filtered, m_) + (1 - memory) * heard;
    MatrixXd e = plant_.C_sigma * x + plant_.D_sigma * c_0;
    if (law_.subtract_applied) e -= r;
    const MatrixXd u = law_.C * x_law + law_.D * e;
    const MatrixXd c_1 = delay_ > 0 ? MatrixXd(S.middleRows(pending, m_)) : u;
    MatrixXd out(S.rows(), S.cols());
    out.topRows(n_) = plant_.Phi * x + plant_.Gamma_0 * c_0 + plant_.Gamma_u * c_1;
    out.middleRows(law, n_law_) = law_.A * x_law + law_.B * e;
    out.middleRows(held, m_) = c_1;
    out.middleRows(filtered, m_) = r;
    queue(S, out, reports, plant_.report_age, report);
    queue(S, out, pending, delay_, u);
    return out;
  }

 private:
  void queue(const MatrixXd& S, MatrixXd& out, Index begin, Index length,
             const MatrixXd& newest) const {
    if (length == 0) return;
    out.middleRows(begin, m_ * (length - 1)) = S.middleRows(begin + m_, m_ * (length - 1));
    out.middleRows(begin + m_ * (length - 1), m_) = newest;
  }

  SampledPlant plant_;
  DiscreteLaw law_;
  Index n_, m_, n_law_, delay_;
};

}  // namespace

bool decays(const controller::Gains& gains) {
  const Simulation simulation(gains);
  // One sample at a time: where modes are far from orthogonal, the rounding of a power of the
  // matrix grows although the loop does not.
  const MatrixXd step =
      balanced(simulation.step(MatrixXd::Identity(simulation.size(), simulation.size())));
  constexpr int n = 100'000;
  VectorXd x = VectorXd::LinSpaced(simulation.size(), 1, 2);
  double log_norm = 0, log_half_way = 0;
  for (int k = 0; k < n; ++k) {
    if (k == n / 2) log_half_way = log_norm;
    x = step * x;
    const double norm = x.norm();
    if (norm == 0) return true;
    if (!std::isfinite(norm)) return false;
    x /= norm;
    log_norm += std::log(norm);
  }
  // Modes that beat against each other may differ by their number; a loop that grows by 1e-4 a
  // sample is at e^5 by then.
  return log_norm - log_half_way < std::log(static_cast<double>(simulation.size()));
}

}  // namespace stillframe::fuzz
