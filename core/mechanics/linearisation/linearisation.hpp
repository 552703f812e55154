#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "core/mechanics/kinematics.hpp"
#include "core/mechanics/scene/quantity.hpp"

namespace stillframe {

struct SignalInfo {
  std::string name, unit;
  Quantity quantity = Quantity::position;
};

/// What the equations are linearised about: the deck's q_0, q'_0 and q''_0.
struct NominalMotion {
  MotionState state;
  Eigen::VectorXd q_d_ddot;  ///< n_d
  Eigen::VectorXd x;         ///< n_x, nodal displacements there, or near
  Eigen::VectorXd e;         ///< n_e, deformations there, or near: how often a hinge has turned

  /// The nodes where the scene says, at rest, without its prescribed values and rates.
  explicit NominalMotion(const Model& model)
      : state(model),
        q_d_ddot(Eigen::VectorXd::Zero(model.n_d)),
        x(Eigen::VectorXd::Zero(model.n_x)),
        e(Eigen::VectorXd::Zero(model.n_e)) {}

  /// False at rest: then C, N and everything else that needs velocities or accelerations is zero
  /// and costs nothing.
  bool moving() const;
  /// Puts data where positions are near those of this motion. hot.
  void place(Data& data) const {
    data.x = x;
    data.e = e;
  }
};

/// A linear input-output model in second-order form about a nominal motion,
///   M q'' + (C + D) q' + (K + N + G) q
///     = B u_f - M_r w'' - (C_r + D_r) w' - (K_r + N_r + G_r) w,
///   y = Y_p q + Y_v q' + Y_a q'' + R_p w + R_v w' + R_a w'' + D_u u_f,
/// for the n_u inputs asked for: a force, torque or stress is u_f itself; a prescribed motion is w,
/// w' or w'' by its quantity, and every motion column has all three (they are one physical input,
/// THEORY section 2). Columns that do not apply are zero. q is n_d, y is n_y. SI units.
struct LinearModel {
  std::vector<std::string> q_names, q_units;
  std::vector<SignalInfo> inputs, outputs;
  Eigen::MatrixXd M, C, D, K, N, G;              ///< n_d x n_d
  Eigen::MatrixXd B;                             ///< n_d x n_u
  Eigen::MatrixXd M_r, C_r, D_r, K_r, N_r, G_r;  ///< n_d x n_u
  Eigen::MatrixXd Y_p, Y_v, Y_a;                 ///< n_y x n_d
  Eigen::MatrixXd R_p, R_v, R_a, D_u;            ///< n_y x n_u
  Eigen::VectorXd x_0;                           ///< n_x, nodal displacements of the nominal motion
  Eigen::VectorXd q_0, q_dot_0, q_ddot_0;        ///< n_d
  Eigen::VectorXd u_0, y_0;                      ///< n_u, n_y, nominal inputs and outputs

  Eigen::MatrixXd damping() const { return C + D; }
  Eigen::MatrixXd stiffness() const { return K + N + G; }
  Eigen::MatrixXd damping_r() const { return C_r + D_r; }
  Eigen::MatrixXd stiffness_r() const { return K_r + N_r + G_r; }
};

/// Which groups of matrices are wanted; the others stay zero and are not computed. Outputs of
/// accelerations and reactions need all of them.
struct Blocks {
  bool mass = true, damping = true, stiffness = true;
};

/// Linearises one model again and again: names are resolved and work space is allocated once.
///   M = DF^T M DF, D = DF_e^T S_d DF_e, K = DF_e^T S DF_e,
///   C = DF^T ((d f_I/d x') DF + 2 M D2F q'),
///   N = DF^T ((d f_I/d x) DF + (d f_I/d x') D2F q' + M (D2F q'' + D3F q' q')) + DF_e^T S_d D2F_e
///   q', G = DF^T (sum_i sigma_i D2_x e_i - d f/d x) DF,
/// with f_I = M x'' - f_in and sigma complete with its reactions. Only the inputs and outputs asked
/// for are computed. Source: deck, sections 5 to 8; THEORY section 2; docs/THEORY.md.
class Lineariser {
 public:
  /// Errors: InputError for an input or output that is not there (a motion along a direction that
  /// is not prescribed, a reaction where nothing holds).
  Lineariser(const Model& model, const std::vector<SceneSignal>& inputs,
             const std::vector<SceneSignal>& outputs, Blocks blocks = {});
  ~Lineariser();
  Lineariser(Lineariser&&) noexcept;

  /// load_factor: of loads, gravity and preloads. sigma_a: stresses beside those of the elements'
  /// laws (n_e), none if empty. Errors: Refusal if the position cannot be reached.
  const LinearModel& about(const NominalMotion& nominal, double load_factor = 1,
                           const Eigen::VectorXd& sigma_a = {});
  /// Kinematics and stresses of the last nominal motion.
  const Data& data() const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

/// Linearises about any motion; about the operating point of the scene:
/// core/mechanics/operating_point.hpp.
LinearModel linearise(const Model& model, const NominalMotion& nominal,
                      const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs, Blocks blocks = {});

/// The unit of a signal: its quantity's, or of a hinge's deformation that of angles and torques.
std::string unit_of(const Model& model, const SceneSignal& signal);

}  // namespace stillframe
