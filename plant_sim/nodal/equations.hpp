#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mechanics/model/model.hpp"
#include "plant_sim/motion/inputs.hpp"
#include "plant_sim/nodal/band_matrix.hpp"

namespace stillframe::nodal {

/// All nodal coordinates with rates and accelerations, prescribed ones included, and the stresses
/// of the deformations that are held.
struct NodalState {
  Eigen::VectorXd x, x_dot, x_ddot;  ///< n_x
  Eigen::VectorXd lambda;            ///< n_l, N or N m
};

/// Factors of a matrix of the size of the equations, and work space to solve with them.
template <class Scalar>
struct Factors {
  BandFactors<Scalar> band;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> ordered;
};

/// The equations of motion in nodal coordinates, with the stresses lambda of the deformations that
/// are zero or prescribed as multipliers,
///   M x'' - f_in - f - f_ext + D_el^T sigma + D_con^T lambda = 0   (n_f free coordinates)
///   D_con x'' + D2_con(x', x') - e_r'' = 0                         (n_l held deformations)
///   sigma = sigma_0 + sigma_a + S e + S_d e',
/// of index 1 in (x, x', x'', lambda), and the positions and rates of the held deformations that
/// they imply. Source: deck, section 3, before the reduction to q^d. The unknowns of the equations
/// are (x'', lambda), size n_f + n_l, coordinates first. Set-up: construction; the rest is hot:
/// noexcept, no allocation.
class Equations {
 public:
  /// model must outlive this.
  explicit Equations(const Model& model);

  Index n_free() const noexcept { return n_free_; }
  Index n_held() const noexcept { return n_held_; }
  Index size() const noexcept { return n_free_ + n_held_; }
  NodalState zero_state() const;

  /// Takes prescribed motion and driving stresses at a time t (s) into the part, and writes the
  /// prescribed coordinates of a state.
  void take_inputs(const Inputs& inputs, double t, NodalState& state) noexcept;
  /// From here on elastic hinges count their turns from the angles of this state.
  void count_turns_from(const NodalState& state) noexcept;

  /// The angles that they have counted (n_e, rad).
  const Eigen::VectorXd& turns() const noexcept { return turn_; }
  void set_turns(const Eigen::VectorXd& turns) noexcept { turn_ = turns; }

  /// The left-hand sides r (size()), N, and the accelerations of held deformations; writes sigma().
  void residual(const NodalState& state, Eigen::VectorXd& r) noexcept;
  /// What is wrong with the held deformations, e - e_r, and with their rates (behind n_free()
  /// zeros, size()).
  void position_errors(const NodalState& state, Eigen::VectorXd& r) noexcept;
  void rate_errors(const NodalState& state, Eigen::VectorXd& r) noexcept;

  /// Writes the derivatives of the residual: d r/d(x'', lambda) alone, or with d r/d x' and d r/d x
  /// beside.
  void differentiate(const NodalState& state, bool all) noexcept;
  /// Factorises [M + c C + c^2 K, D_con^T; D_con + c .. + c^2 .., 0], the derivative of the
  /// residual where x' moves by c x'' and x by c^2 x''; false if it is singular.
  template <class Scalar>
  bool factorise(Factors<Scalar>& factors, Scalar c) const noexcept {
    return c == Scalar(0) ? factors.band.factorise(mass_)
                          : factors.band.factorise(mass_, c, damping_, stiffness_);
  }
  /// Solves with factors, in place (size()).
  template <class Scalar>
  void solve(Factors<Scalar>& factors, Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& r) const noexcept {
    for (Index i = 0; i < size(); ++i) factors.ordered(place_of(i)) = r(i);
    factors.band.solve(factors.ordered);
    for (Index i = 0; i < size(); ++i) r(i) = factors.ordered(place_of(i));
  }
  template <class Scalar>
  Factors<Scalar> factors() const {
    return {{size(), half_bandwidth()}, Eigen::Matrix<Scalar, Eigen::Dynamic, 1>::Zero(size())};
  }
  /// r += factor d r/d x dx, and r += d r/d x'' dx (dx: n_f).
  void add_stiffness_product(double factor, const Eigen::Ref<const Eigen::VectorXd>& dx,
                             Eigen::VectorXd& r) noexcept {
    add_product(stiffness_, factor, dx, r);
  }
  void add_mass_product(const Eigen::Ref<const Eigen::VectorXd>& dx, Eigen::VectorXd& r) noexcept {
    add_product(mass_, 1, dx, r);
  }

  /// All stresses (n_e) of the last residual.
  const Eigen::VectorXd& sigma() const noexcept { return sigma_; }
  /// The driving stresses (n_e) of the last inputs.
  const Eigen::VectorXd& sigma_a() const noexcept { return sigma_a_; }
  /// Largest forces (n_f, N) that rounding of the displacements and stresses may leave unbalanced
  /// at a state, after residual(). set-up.
  Eigen::VectorXd rounding(const NodalState& state) const;
  Index half_bandwidth() const noexcept { return mass_.half_bandwidth(); }

 private:
  /// One element in its place.
  struct Place {
    const ModelElement* item;
    std::vector<Index> unknown;  ///< n_local: number of a free coordinate, or -1
    std::vector<Index> held;     ///< n_e: number among the held deformations, or -1
    bool any_held = false, any_elastic = false;
  };
  struct Mass {
    const ModelInertia* item;
    std::vector<Index> unknown;
  };

  void number_held();
  void order_unknowns();
  std::vector<Index> unknowns_of(const std::vector<PartMap>& parts) const;
  void stresses(const Place& place, const LocalVector& u, const LocalVector& v,
                const LocalJacobian& D, const NodalState& state, LocalDeformation& s) noexcept;
  void add_element(const Place& place, const NodalState& state, Eigen::VectorXd& r) noexcept;
  void add_mass(const Mass& mass, const NodalState& state, Eigen::VectorXd& r) noexcept;
  void differentiate_element(const Place& place, const NodalState& state, bool all) noexcept;
  void differentiate_mass(const Mass& mass, const NodalState& state, bool all) noexcept;
  void differentiate_turning_loads(const NodalState& state) noexcept;
  void add_square(const std::vector<Index>& unknown, const LocalHessian& block,
                  BandMatrix& matrix) noexcept;
  void add_product(const BandMatrix& matrix, double factor,
                   const Eigen::Ref<const Eigen::VectorXd>& dx, Eigen::VectorXd& r) noexcept;
  Index place_of(Index unknown) const noexcept { return order_[static_cast<size_t>(unknown)]; }

  const Model& model_;
  Index n_free_, n_held_ = 0;
  std::vector<Place> places_;
  std::vector<Mass> masses_;
  std::vector<Index> held_of_row_;    ///< n_e, or -1
  std::vector<Index> prescribed_of_;  ///< n_l: number among the prescribed deformations, or -1
  std::vector<double> period_;        ///< n_e, 0 where a deformation does not repeat
  std::vector<Index> order_;          ///< size(): place in the matrices
  Eigen::VectorXd q_r_, q_r_dot_, q_r_ddot_, sigma_a_, sigma_, turn_;
  const Eigen::VectorXd* external_ = nullptr;
  BandMatrix mass_{0, 0}, damping_{0, 0}, stiffness_{0, 0};
  Eigen::VectorXd ordered_, product_;
};

}  // namespace stillframe::nodal
