#include "core/mechanics/certificate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/linearisation/signal_rows.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/extrapolation.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

enum class Order { position, velocity, acceleration };

/// The nonlinear equations beside the linear model: one model of their own, whose loads may change.
class Certifier {
 public:
  Certifier(const Scene& scene, const std::function<void(double)>& progress)
      : scene_(scene),
        progress_(progress),
        model_(make_model(scene)),
        nominal_(nominal_motion(model_)),
        linear_(linearise(model_, nominal_, scene.inputs, scene.outputs)),
        data_(model_),
        sigma_a_(VectorXd::Zero(model_.n_e)) {
    for (const SceneSignal& output : scene.outputs) {
      outputs_.push_back(resolve_output(model_, output));
    }
    for (const SceneSignal& input : scene.inputs) {
      inputs_.push_back(resolve_input(model_, input));
    }
    evaluate(nominal_.state, nominal_.q_d_ddot);
    base_ = data_;
    base_inertia_ = inertia_forces(model_, data_).head(model_.n_x);
    M_.compute(linear_.M);
    if (M_.info() != Eigen::Success) throw Refusal("the mass matrix is not positive definite");
  }

  std::vector<BlockCertificate> run() {
    second_order_blocks();
    whole_equations();
    return std::move(result_);
  }

 private:
  /// Everything at given q''; positions start from the nominal ones.
  void evaluate(const MotionState& state, const VectorXd& q_d_ddot) {
    nominal_.place(data_);
    if (!generalised_forces(model_, data_, state, sigma_a_)) {
      throw Refusal("a position near the operating point cannot be reached");
    }
    complete_accelerations(data_, q_d_ddot);
    reaction_stresses(model_, data_);
  }

  Index n_columns() const { return model_.n_d + static_cast<Index>(inputs_.size()); }
  bool is_motion_column(Index j) const {
    return j < model_.n_d || is_motion(inputs_[static_cast<size_t>(j - model_.n_d)].quantity);
  }
  /// A state (with q'') that differs by t in one column and order.
  std::pair<MotionState, VectorXd> changed(Index j, Order order, double t) const {
    std::pair<MotionState, VectorXd> at{nominal_.state, nominal_.q_d_ddot};
    MotionState& s = at.first;
    if (j < model_.n_d) {
      (order == Order::position ? s.q_d : order == Order::velocity ? s.q_d_dot : at.second)(j) += t;
    } else {
      (order == Order::position   ? s.q_r
       : order == Order::velocity ? s.q_r_dot
                                  : s.q_r_ddot) +=
          t * model_.prescribed_pattern(scene_.inputs[static_cast<size_t>(j - model_.n_d)]);
    }
    return at;
  }
  /// A step of column j that moves nodes by about a hundredth of the scene's size, or of a radian.
  double step(Index j) {
    MotionState unit(model_);
    VectorXd x;
    if (j < model_.n_d) {
      x = base_.DF.col(j);
    } else {
      x = prescribed_transfer_functions(
          model_, base_,
          model_.prescribed_pattern(scene_.inputs[static_cast<size_t>(j - model_.n_d)]));
    }
    const double largest = largest_move(model_, x);
    return largest > 0 ? 0.02 / largest : 0.02;
  }

  /// By extrapolation, from steps that are small enough for their positions to be reached: near a
  /// singular one those that are usual elsewhere are not.
  Extrapolated derivative(const std::function<VectorXd(double)>& values, double step) {
    for (int k = 0;; ++k) {
      try {
        return extrapolated_derivative(values, step);
      } catch (const Refusal&) {
        if (k == 6) throw;
        step /= 4;
        data_ = base_;  // the factors are those of where it ended
      }
    }
  }

  /// The same of q''^d and y; entries that are not known well enough are those of the step, out of
  /// some, that they are known best from. A hundredth of the scene is far for an element that is a
  /// fiftieth of it; and what is linear, as answers to accelerations are, rounds the less the
  /// longer the step is.
  Extrapolated best_derivative(const std::function<VectorXd(double)>& values, double step) {
    Extrapolated best = derivative(values, step);
    for (const double factor : {8.0, 0.125, 64.0, 1.0 / 64}) {
      const VectorXd scale = scales_of(best.value);
      if ((best.known_to.array() <= 0.1 * certified_difference * scale.array()).all()) break;
      try {
        const Extrapolated other = extrapolated_derivative(values, factor * step);
        for (Index i = 0; i < scale.size(); ++i) {
          if (!(other.known_to(i) < best.known_to(i))) continue;
          best.value(i) = other.value(i);
          best.known_to(i) = other.known_to(i);
        }
      } catch (const Refusal&) {
        // Then this step tells nothing.
      }
      // What such a step led to, which may be no number, is no place to go on from.
      data_ = base_;
    }
    return best;
  }
  /// What entries of q''^d and y are judged by, as far as one column tells: judge().
  VectorXd scales_of(const VectorXd& answer) const {
    VectorXd scale = answer.cwiseAbs();
    const Index n = model_.n_d;
    scale.tail(scale.size() - n) =
        scale.tail(scale.size() - n).cwiseMax(1e-6 * (linear_.Y_a.cwiseAbs() * scale.head(n)));
    scale.head(n).setConstant(worst_of(answer.head(n)));
    return scale;
  }

  /// DF_e^T sigma with the transfer functions of the operating point.
  VectorXd project_stresses(const RowMatrix& DF_e, const VectorXd& sigma) const {
    VectorXd f = DF_e.transpose() * sigma.tail(model_.n_redundant);
    for (Index i = 0; i < model_.n_d; ++i) {
      const Model::Dof& dof = model_.dofs[static_cast<size_t>(i)];
      if (dof.is_deformation) f(i) += sigma(dof.index);
    }
    return f;
  }
  /// S e or S_d e' of all elements.
  VectorXd elastic(bool viscous) const {
    VectorXd sigma = VectorXd::Zero(model_.n_e);
    for (const ModelElement& item : model_.elements) {
      const MatrixXd& S = viscous ? item.S_d : item.S;
      const VectorXd& e = viscous ? data_.e_dot : data_.e;
      for (Index i = 0; i < S.rows(); ++i) {
        for (Index k = 0; k < S.rows(); ++k) {
          if (item.zero[static_cast<size_t>(k)]) continue;
          sigma(item.row[static_cast<size_t>(i)]) += S(i, k) * e(item.row[static_cast<size_t>(k)]);
        }
      }
    }
    if (viscous && model_.modal_dampers.size() > 0) {
      sigma += model_.modal_dampers * (model_.modal_dampers.transpose() * data_.e_dot);
    }
    return sigma;
  }

  /// The force of a block at the state in data_; the part that the block holds constant is that of
  /// the operating point.
  VectorXd force_of(char block) const {
    const auto inertia = [&] { return inertia_forces(model_, data_).head(model_.n_x).eval(); };
    switch (block) {
      case 'M':
      case 'C':
        return base_.DF.transpose() * inertia();
      case 'D':
        return project_stresses(base_.DF_e, elastic(true));
      case 'K':
        return project_stresses(base_.DF_e, elastic(false));
      case 'N':
        return base_.DF.transpose() * inertia() + project_stresses(base_.DF_e, elastic(true));
      default:
        return data_.DF.transpose() *
                   (base_inertia_ - applied_forces(model_, data_).head(model_.n_x)) +
               data_.DF_e.transpose() * base_.sigma.tail(model_.n_redundant);
    }
  }

  void second_order_blocks() {
    const struct {
      char name;
      Order order;
      double factor;  ///< of the step
      const MatrixXd &dofs, &motions;
    } blocks[] = {{'M', Order::acceleration, 100, linear_.M, linear_.M_r},
                  {'C', Order::velocity, 10, linear_.C, linear_.C_r},
                  {'D', Order::velocity, 10, linear_.D, linear_.D_r},
                  {'K', Order::position, 1, linear_.K, linear_.K_r},
                  {'N', Order::position, 1, linear_.N, linear_.N_r},
                  {'G', Order::position, 1, linear_.G, linear_.G_r}};
    for (const auto& block : blocks) {
      double difference = 0, known_to = 0, size = 0, scale = 0;
      for (Index j = 0; j < n_columns(); ++j) {
        column_done();
        if (!is_motion_column(j)) continue;
        const auto [expected, rounding] = derivative(
            [&](double t) {
              const auto [state, q_ddot] = changed(j, block.order, t);
              evaluate(state, q_ddot);
              return force_of(block.name);
            },
            block.factor * step(j));
        const VectorXd found =
            j < model_.n_d ? block.dofs.col(j) : block.motions.col(j - model_.n_d);
        difference = worst_of(difference, worst_of(found - expected));
        known_to = worst_of(known_to, worst_of(rounding));
        size = worst_of(size, worst_of(found));
        scale = worst_of(scale, worst_of(expected));
      }
      add(std::string(1, block.name), difference, known_to, worst_of(size, scale),
          worst_of(rounding_floor(block.order),
                   moving_rounding(block.name) / certified_difference));
    }
  }

  /// What rounding leaves of C and N where the operating point moves, whatever is left of the terms
  /// they are sums of: M D2F q', M D3F q' q', S_d D2F_e q'. A rotor's motion reaches the rows of a
  /// frame that does not turn by way of one solution with J, and sums over n_x coordinates: each
  /// known to n eps of its terms, times what that solution makes of them (N. J. Higham, Accuracy
  /// and stability of numerical algorithms, chapters 3, 7 and 9).
  double moving_rounding(char block) const {
    const double terms = moving_terms(block);
    if (terms == 0) return 0;
    return static_cast<double>(model_.n_x) * std::numeric_limits<double>::epsilon() * terms *
           base_.J.componentwise_condition();
  }
  double moving_terms(char block) const {
    const double rate = largest_move(model_, base_.x_dot),
                 acceleration = largest_move(model_, base_.x_ddot),
                 mass = worst_of(worst_of(linear_.M), worst_of(linear_.M_r)),
                 damping = worst_of(worst_of(linear_.D), worst_of(linear_.D_r));
    switch (block) {
      case 'C':
        return mass * rate;
      case 'N':
        return mass * (rate * rate + acceleration) + damping * rate;
      default:
        return 0;
    }
  }

  /// floor: a block below it is zero to rounding of its neighbours.
  void add(const std::string& name, double difference, double known_to, double size, double floor) {
    const double scale = worst_of(size, floor);
    const auto relative = [scale](double error) { return error == 0 ? 0 : error / scale; };
    result_.push_back({name, relative(difference), relative(known_to), size});
  }
  /// 1e-12 of the largest block of the same unit; of rates also of what masses on springs have.
  double rounding_floor(Order order) const {
    const LinearModel& l = linear_;
    const double position = worst_of({worst_of(l.K), worst_of(l.N), worst_of(l.G)});
    const double mass = worst_of(l.M);
    const double size = order == Order::position ? position
                        : order == Order::velocity
                            ? worst_of({worst_of(l.C), worst_of(l.D), std::sqrt(mass * position)})
                            : mass;
    // Where all blocks of a unit are zero, those of the next unit say how large forces are.
    return 1e-12 * (size != 0 ? size : worst_of(mass, position));
  }

  /// q''^d and y of the equations as they are simulated, with one input changed.
  VectorXd answer(Index j, Order order, double t) {
    auto [state, q_ddot] = changed_or_same(j, order, t);
    const VectorXd load = model_.load, fixed_load = model_.fixed_load;
    const size_t n_turning = model_.turning_loads.size();
    sigma_a_.setZero();
    if (j >= model_.n_d && !is_motion_column(j))
      push(inputs_[static_cast<size_t>(j - model_.n_d)], t);
    nominal_.place(data_);
    const auto status = accelerations(model_, data_, state, sigma_a_, q_ddot);
    if (status != DynamicsStatus::ok) {
      throw Refusal("the equations of motion cannot be evaluated near the operating point");
    }
    reaction_stresses(model_, data_);
    VectorXd result(model_.n_d + static_cast<Index>(outputs_.size()));
    result << q_ddot, nonlinear_outputs(model_, data_, outputs_, nominal_.x);
    model_.load = load;
    model_.fixed_load = fixed_load;
    model_.turning_loads.resize(n_turning);
    sigma_a_.setZero();
    return result;
  }
  std::pair<MotionState, VectorXd> changed_or_same(Index j, Order order, double t) const {
    if (is_motion_column(j)) return changed(j, order, t);
    return {nominal_.state, nominal_.q_d_ddot};
  }
  void push(const ResolvedSignal& input, double t) {
    if (input.quantity == Quantity::stress) {
      sigma_a_(input.row) = t;
    } else if (input.quantity == Quantity::force || model_.planar) {
      const VectorXd f = t * unit_force(model_, nominal_.x, input);
      model_.load += f.head(model_.n_x);
      model_.fixed_load += f.tail(model_.n_0);
    } else {
      model_.turning_loads.push_back(
          {input.node, Eigen::Vector3d::Zero(), t * input.direction, false});
    }
  }

  /// Columns of the linear model: q''^d and y answering one change.
  VectorXd predicted(Index j, Order order) const {
    const auto both = [&](const VectorXd& force, const VectorXd& y) {
      VectorXd result(force.size() + y.size());
      result.head(force.size()) = M_.solve(force);
      result.tail(y.size()) = y + linear_.Y_a * result.head(force.size());
      return result;
    };
    const LinearModel& l = linear_;
    if (j < model_.n_d) {
      return order == Order::position ? both(-l.stiffness().col(j), l.Y_p.col(j))
                                      : both(-l.damping().col(j), l.Y_v.col(j));
    }
    const Index k = j - model_.n_d;
    if (!is_motion_column(j)) return both(l.B.col(k), l.D_u.col(k));
    return order == Order::position   ? both(-l.stiffness_r().col(k), l.R_p.col(k))
           : order == Order::velocity ? both(-l.damping_r().col(k), l.R_v.col(k))
                                      : both(-l.M_r.col(k), l.R_a.col(k));
  }

  void whole_equations() {
    const Index n_y = static_cast<Index>(outputs_.size());
    // Columns of A and C_y, then of B and D_y.
    answers_to_states_.setZero(n_y);
    for (const bool states : {true, false}) {
      MatrixXd found(model_.n_d + n_y, 0), expected = found, rounding = found;
      const Index first = states ? 0 : model_.n_d, last = states ? model_.n_d : n_columns();
      for (Index j = first; j < last; ++j) {
        column_done();
        std::vector<std::pair<Order, double>> orders = {{Order::position, 1},
                                                        {Order::velocity, 10}};
        if (!states) orders.push_back({Order::acceleration, 100});
        if (!is_motion_column(j)) orders = {{Order::position, 1}};
        for (const auto& [order, factor] : orders) {
          const double h = is_motion_column(j) ? factor * step(j) : 1.0;
          found.conservativeResize(Eigen::NoChange, found.cols() + 1);
          expected.conservativeResize(Eigen::NoChange, expected.cols() + 1);
          rounding.conservativeResize(Eigen::NoChange, rounding.cols() + 1);
          found.rightCols<1>() = predicted(j, order);
          const Extrapolated differences =
              best_derivative([&](double t) { return answer(j, order, t); }, h);
          expected.rightCols<1>() = differences.value;
          rounding.rightCols<1>() = differences.known_to;
        }
      }
      if (found.cols() == 0) continue;
      const MatrixXd q_ddot = found.topRows(model_.n_d);
      const MatrixXd y = found.bottomRows(n_y), from_q_ddot = linear_.Y_a * q_ddot;
      MatrixXd terms(n_y, 2 * y.cols());
      terms << (y - from_q_ddot).cwiseAbs() + linear_.Y_a.cwiseAbs() * q_ddot.cwiseAbs(),
          answers_to_states_.replicate(1, y.cols());
      if (states) answers_to_states_ = terms.rowwise().maxCoeff();
      judge(states ? "A" : "B", q_ddot, expected.topRows(model_.n_d), rounding.topRows(model_.n_d),
            q_ddot.cwiseAbs(), false);
      judge(states ? "C_y" : "D_y", y, expected.bottomRows(n_y), rounding.bottomRows(n_y), terms,
            true);
    }
  }

  /// terms: the sizes of what an output's entries are the sums of, and its answers to the states.
  /// An output that answers less than 1e-6 of them, or 1e-12 of the largest output, is zero to
  /// rounding.
  void judge(const std::string& name, const MatrixXd& found, const MatrixXd& expected,
             const MatrixXd& rounding, const MatrixXd& terms, bool by_row) {
    if (found.size() == 0) return;
    const double size = worst_of(found);
    // A sum is known to n eps of its terms, which differences show by chance alone (N. J. Higham,
    // chapter 3): a reaction that is nothing but what stiff parts leave of each other.
    const double summing = static_cast<double>(model_.n_d) * std::numeric_limits<double>::epsilon();
    double difference = 0, known_to = 0;
    for (Index i = 0; i < found.rows(); ++i) {
      const double row = worst_of(
          {worst_of(expected.row(i)), 1e-6 * worst_of(terms.row(i)), 1e-12 * worst_of(terms)});
      const double scale = by_row ? row : size;
      if (scale != 0) {
        difference = worst_of(difference, worst_of((found - expected).row(i)) / scale);
        known_to = worst_of({known_to, worst_of(rounding.row(i)) / scale,
                             summing * worst_of(terms.row(i)) / scale});
      }
    }
    result_.push_back({name, difference, known_to, size});
  }

  /// One of the columns of the six blocks, or of the whole equations, is done.
  void column_done() { progress_(++columns_done_ / static_cast<double>(7 * n_columns())); }

  const Scene& scene_;
  const std::function<void(double)>& progress_;
  double columns_done_ = 0;
  Model model_;
  NominalMotion nominal_;
  LinearModel linear_;
  Data data_;
  Data base_{model_};
  VectorXd sigma_a_, base_inertia_, answers_to_states_;
  std::vector<ResolvedSignal> inputs_, outputs_;
  Eigen::LLT<MatrixXd> M_;
  std::vector<BlockCertificate> result_;
};

}  // namespace

std::vector<BlockCertificate> certify(const Scene& scene,
                                      const std::function<void(double)>& progress) {
  return Certifier(scene, progress).run();
}

}  // namespace stillframe
