#include "core/mechanics/stationarity.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/force_balance.hpp"
#include "core/mechanics/model/prescribed.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

bool goes_on(const NominalMotion& nominal) {
  return !nominal.state.q_r_dot.isZero(0) || !nominal.state.q_r_ddot.isZero(0);
}

/// Zero where it moves the nodes by less than 1e-9 of what the prescribed motion does: rounding of
/// coordinates that go along by themselves.
VectorXd beyond_rounding(const Model& model, const RowMatrix& DF, const VectorXd& rate,
                         const VectorXd& of_nodes) {
  if (largest_move(model, DF * rate) <= 1e-9 * largest_move(model, of_nodes)) {
    return VectorXd::Zero(rate.size());
  }
  return rate;
}

}  // namespace

Rates rates_along(const Model& model, const NominalMotion& nominal) {
  Lineariser lineariser(model, prescribed_signals(model), {}, {.mass = false});
  const LinearModel& linear = lineariser.about(nominal);
  const VectorXd &v = nominal.state.q_r_dot, &a = nominal.state.q_r_ddot;
  const MatrixXd K = linear.stiffness(), K_r = linear.stiffness_r();
  Data data = lineariser.data();
  Rates rates;
  rates.acceleration = beyond_rounding(model, data.DF, -motion_against(K, K_r * a),
                                       prescribed_transfer_functions(model, data, a).col(0));
  rates.velocity = beyond_rounding(
      model, data.DF,
      -motion_against(K, K_r * v + linear.damping_r() * a + linear.damping() * rates.acceleration),
      prescribed_transfer_functions(model, data, v).col(0));
  return rates;
}

namespace {

/// What is smaller than this part of what it is compared with is rounding: of the position that the
/// motion has gone to, and of stiff elements in it.
constexpr double same = 1e-7;

/// One time to go on by, and the prescribed coordinates that do: those that are very much faster
/// stay, as the parts of their turns are looked at by themselves.
struct Instant {
  double time = 0;                             ///< s
  Eigen::Array<bool, Eigen::Dynamic, 1> goes;  ///< n_r
};

/// The time in which v t + a t^2 / 2 is s, all of one sign.
double time_for(double s, double v, double a) {
  if (a == 0) return s / v;
  return 2 * s / (v + std::sqrt(v * v + 2 * a * s));
}

std::vector<Instant> instants(const Model& model, const NominalMotion& nominal) {
  const double size = scene_size(model);
  // How long each coordinate takes for a turn, or for the size of the scene.
  VectorXd period(model.n_r);
  const std::vector<SceneSignal> signals = prescribed_signals(model);
  for (Index i = 0; i < model.n_r; ++i) {
    const double whole = is_angle(model, signals[static_cast<size_t>(i)]) ? two_pi : size;
    period(i) =
        time_for(whole, std::abs(nominal.state.q_r_dot(i)), std::abs(nominal.state.q_r_ddot(i)));
  }
  std::vector<double> periods;
  for (const double p : period) {
    const auto near = [p](double other) { return std::abs(other - p) <= 1e-3 * p; };
    if (std::isfinite(p) && std::none_of(periods.begin(), periods.end(), near)) {
      periods.push_back(p);
    }
  }
  std::vector<Instant> all;
  for (const double p : periods) {
    // Parts that no number of legs or blades has in common: of the golden section and its powers.
    for (const double part : {0.0557281, 0.2360680, 0.3819660}) {
      all.push_back({part * p, period.array() >= 0.01 * p});
    }
  }
  return all;
}

NominalMotion gone_on(const NominalMotion& from, const Instant& instant) {
  NominalMotion to = from;
  const double t = instant.time;
  MotionState& s = to.state;
  s.q_d += t * (s.q_d_dot + 0.5 * t * to.q_d_ddot);
  s.q_d_dot += t * to.q_d_ddot;
  for (Index i = 0; i < s.q_r.size(); ++i) {
    if (!instant.goes(i)) continue;
    s.q_r(i) += t * (s.q_r_dot(i) + 0.5 * t * s.q_r_ddot(i));
    s.q_r_dot(i) += t * s.q_r_ddot(i);
  }
  return to;
}

/// "'axle' (rate 3)" of all that has a rate or an acceleration.
std::string motions_in_words(const Model& model, const NominalMotion& nominal) {
  std::string text;
  const std::vector<SceneSignal> signals = prescribed_signals(model);
  for (size_t i = 0; i < signals.size(); ++i) {
    const auto k = static_cast<Index>(i);
    const double v = nominal.state.q_r_dot(k), a = nominal.state.q_r_ddot(k);
    if (v == 0 && a == 0) continue;
    text += (text.empty() ? "'" : ", '") + signals[i].name +
            formatted(a == 0 ? "' (rate %.4g)" : "' (rate %.4g, acceleration %.4g)", v, a);
  }
  return text;
}

/// Compares the matrices of a linear model with themselves later, each entry beside what the model
/// makes of it: with k_i and m_i the stiffness and mass of a dof alone and w_i^2 = k_i / m_i, a
/// force counts as f_i / sqrt(k_i) and a motion as sqrt(k_i) q_i.
class Comparison {
 public:
  Comparison(const Model& model, Data& data, const LinearModel& first,
             const std::vector<SceneSignal>& inputs)
      : first_(first) {
    k_ = (first.K.diagonal().cwiseAbs() + first.N.diagonal().cwiseAbs() +
          first.G.diagonal().cwiseAbs())
             .cwiseSqrt();
    const VectorXd m = first.M.diagonal().cwiseAbs().cwiseSqrt();
    w_ = VectorXd::Zero(k_.size());
    for (Index i = 0; i < k_.size(); ++i) {
      if (m(i) > 0) w_(i) = k_(i) / m(i);
    }
    // Where nothing resists a dof, or nothing but rounding, it counts as very slow.
    const double fastest = w_.size() ? w_.maxCoeff() : 0.0;
    w_ = w_.cwiseMax(fastest > 0 ? 1e-6 * fastest : 1.0);
    k_ = k_.cwiseMax(m.cwiseProduct(w_));
    for (double& k : k_) {
      if (k == 0) k = 1;
    }
    find_usual_sizes(model, data, inputs);
  }

  /// What is not the same any more, in words; empty if all is.
  std::string difference(const LinearModel& later) const {
    if (const std::string dof = of_dofs(later); !dof.empty()) return "the motion of dof " + dof;
    if (const std::string name = of_inputs(later); !name.empty()) return "input '" + name + "'";
    if (const std::string name = of_outputs(later); !name.empty()) return "output '" + name + "'";
    return "";
  }

 private:
  /// What an input or output of its kind has where it does something to the dofs: it is compared
  /// with 1e-4 of that at least, as one that does nothing is rounding alone.
  void find_usual_sizes(const Model& model, Data& data, const std::vector<SceneSignal>& inputs) {
    double motion = 0, force = 0, stress = 0;
    for (Index i = 0; i < k_.size(); ++i) {
      const double move = worst_of(data.DF.col(i));
      if (move > 0) motion = worst_of(motion, k_(i) / move);
      force = worst_of(force, move / k_(i));
      stress = worst_of(stress, k_(i));
    }
    usual_input_ = VectorXd::Constant(static_cast<Index>(inputs.size()), force);
    for (size_t j = 0; j < inputs.size(); ++j) {
      if (!is_motion(inputs[j].quantity)) continue;
      const VectorXd pattern = model.prescribed_pattern(inputs[j]);
      usual_input_(static_cast<Index>(j)) =
          motion * worst_of(prescribed_transfer_functions(model, data, pattern));
    }
    usual_output_ = VectorXd::Constant(static_cast<Index>(first_.outputs.size()), stress);
    for (size_t i = 0; i < first_.outputs.size(); ++i) {
      if (is_motion(first_.outputs[i].quantity)) usual_output_(static_cast<Index>(i)) = force;
    }
  }

  std::string of_dofs(const LinearModel& later) const {
    const auto changed = [&](const MatrixXd& a, const MatrixXd& b, int order) -> Index {
      for (Index i = 0; i < a.rows(); ++i) {
        for (Index j = 0; j < a.cols(); ++j) {
          const double frequency = std::pow(w_(i) * w_(j), 0.5 * order);
          if (!(std::abs(b(i, j) - a(i, j)) * frequency <= same * k_(i) * k_(j))) return i;
        }
      }
      return -1;
    };
    const Index found =
        std::max({changed(first_.M, later.M, 2), changed(first_.damping(), later.damping(), 1),
                  changed(first_.stiffness(), later.stiffness(), 0)});
    return found < 0 ? "" : first_.q_names[static_cast<size_t>(found)];
  }

  /// What an input does to the dofs at their own frequencies: the forces, or the motion's three.
  struct Effect {
    MatrixXd force, position, velocity, acceleration;
  };
  Effect effect_of_inputs(const LinearModel& m) const {
    const auto weighted = [&](const MatrixXd& matrix, int order) -> MatrixXd {
      return (w_.array().pow(order) / k_.array()).matrix().asDiagonal() * matrix;
    };
    return {weighted(m.B, 0), weighted(m.stiffness_r(), 0), weighted(m.damping_r(), 1),
            weighted(m.M_r, 2)};
  }
  static VectorXd sizes(const Effect& e, bool of_columns) {
    VectorXd result = VectorXd::Zero(of_columns ? e.force.cols() : e.force.rows());
    for (const MatrixXd* part : {&e.force, &e.position, &e.velocity, &e.acceleration}) {
      for (Index i = 0; i < result.size(); ++i) {
        result(i) =
            worst_of(result(i), of_columns ? worst_of(part->col(i)) : worst_of(part->row(i)));
      }
    }
    return result;
  }
  static Effect minus(const Effect& a, const Effect& b) {
    return {a.force - b.force, a.position - b.position, a.velocity - b.velocity,
            a.acceleration - b.acceleration};
  }
  std::string of_inputs(const LinearModel& later) const {
    const Effect a = effect_of_inputs(first_), b = effect_of_inputs(later);
    const VectorXd size = sizes(a, true).cwiseMax(sizes(b, true)).cwiseMax(little * usual_input_),
                   change = sizes(minus(a, b), true);
    for (Index j = 0; j < change.size(); ++j) {
      if (!(change(j) <= same * size(j))) return first_.inputs[static_cast<size_t>(j)].name;
    }
    return "";
  }

  Effect effect_on_outputs(const LinearModel& m) const {
    const auto weighted = [&](const MatrixXd& matrix, int order) -> MatrixXd {
      return matrix * (w_.array().pow(order) / k_.array()).matrix().asDiagonal();
    };
    return {MatrixXd::Zero(m.Y_p.rows(), m.Y_p.cols()), weighted(m.Y_p, 0), weighted(m.Y_v, 1),
            weighted(m.Y_a, 2)};
  }
  std::string of_outputs(const LinearModel& later) const {
    const Effect a = effect_on_outputs(first_), b = effect_on_outputs(later);
    const VectorXd size =
                       sizes(a, false).cwiseMax(sizes(b, false)).cwiseMax(little * usual_output_),
                   change = sizes(minus(a, b), false);
    const Effect inputs = effect_of_inputs(first_);
    const VectorXd from_inputs = sizes(inputs, true);
    const double w = w_.size() ? w_.maxCoeff() : 1.0;
    for (Index i = 0; i < change.size(); ++i) {
      const std::string& name = first_.outputs[static_cast<size_t>(i)].name;
      if (!(change(i) <= same * size(i))) return name;
      // What goes straight through, beside the same and beside what goes through the dofs.
      for (Index j = 0; j < from_inputs.size(); ++j) {
        const double weights[] = {1, 1, w, w * w};
        double through = 0, direct = worst_of(size(i) * from_inputs(j),
                                              little * usual_output_(i) * usual_input_(j));
        const MatrixXd* parts[][2] = {{&first_.D_u, &later.D_u},
                                      {&first_.R_p, &later.R_p},
                                      {&first_.R_v, &later.R_v},
                                      {&first_.R_a, &later.R_a}};
        for (int k = 0; k < 4; ++k) {
          const double x = (*parts[k][0])(i, j), y = (*parts[k][1])(i, j);
          direct = worst_of(direct, weights[k] * worst_of(std::abs(x), std::abs(y)));
          through = worst_of(through, weights[k] * std::abs(x - y));
        }
        if (!(through <= same * direct)) return name;
      }
    }
    return "";
  }

  const LinearModel& first_;
  VectorXd k_, w_;                       ///< n_d: sqrt(k_i) and w_i
  VectorXd usual_input_, usual_output_;  ///< n_u, n_y
  static constexpr double little = 1e-4;
};

/// sqrt(e^T S e) of all elements: does not change where the same strain goes round a shaft.
double elastic_amplitude(const Model& model, const Data& data) {
  return std::sqrt(std::max(2 * elastic_energy(model, data), 0.0));
}

/// That of the rounding of positions.
double rounding_amplitude(const Model& model, const Data& data) {
  const double rounding = 1e-12 * largest_move(model, data.x), size = scene_size(model);
  double twice = 0;
  for (const ModelElement& item : model.elements) {
    const bool angle = item.element->period() > 0;
    twice += item.S.trace() * (angle ? 1 : size * size);
  }
  return rounding * std::sqrt(twice);
}

[[noreturn]] void refuse(const Model& model, const NominalMotion& nominal, const std::string& why) {
  throw Refusal(
      "the motion is not stationary: as " + motions_in_words(model, nominal) + " goes on, " + why +
      "; a snapshot of the motion as written is what operating_point: as_written asks for");
}

}  // namespace

void require_stationary(const Model& model, const NominalMotion& nominal,
                        const std::vector<SceneSignal>& inputs,
                        const std::vector<SceneSignal>& outputs) {
  if (!goes_on(nominal)) return;
  Lineariser lineariser(model, inputs, outputs);
  const LinearModel first = lineariser.about(nominal);
  Data data = lineariser.data();
  const Comparison comparison(model, data, first, inputs);
  const double strain = elastic_amplitude(model, data);
  const double reference = largest_balanced_work(model, data, nominal);
  for (const Instant& instant : instants(model, nominal)) {
    nominal.place(data);
    NominalMotion later = gone_on(nominal, instant);
    if (!travel(model, data, nominal.state, later.state)) {
      refuse(model, nominal, "there is soon no position that it leads to");
    }
    later.x = data.x;
    later.e = data.e;
    VectorXd f(model.n_d);
    const bool reached = out_of_balance(model, data, later, f);
    // 1e-7 is what an equilibrium may leave.
    if (!reached || !(largest_work(model, data, f) <=
                      10 * same * reference + work_of_rounding(model, data, first.stiffness()))) {
      Index dof = 0;
      if (reached) f.cwiseAbs().maxCoeff(&dof);
      refuse(model, nominal,
             "forces that balance now do not any more (dof " +
                 model.dofs[static_cast<size_t>(dof)].name +
                 "), or its dofs do not go along: those that do are deformations");
    }
    if (!(std::abs(elastic_amplitude(model, data) - strain) <=
          10 * same * strain + rounding_amplitude(model, data))) {
      refuse(model, nominal, "it winds up the elastic elements more and more, or lets them go");
    }
    const std::string changed = comparison.difference(lineariser.about(later));
    if (!changed.empty()) {
      refuse(model, nominal,
             changed.starts_with("the motion")
                 ? "the equations of " + changed.substr(4) +
                       " change, or its dofs do not go along: those that do are deformations"
                 : changed +
                       " sees it change: what is fixed in the world does not go along, a "
                       "deformation or a stress of an element does");
    }
  }
}

}  // namespace stillframe
