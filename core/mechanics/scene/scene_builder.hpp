#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene.hpp"

// A scene in C++, without a file. Names of keys, units, defaults and ranges are those of
// docs/scene.md; what is not given is left out.
namespace stillframe {

/// One number, a column of numbers, or a matrix, whose size the scene decides: where a number for
/// each deformation is wanted n_e of them, or n_e x n_e. Empty: not given.
class SceneNumbers {
 public:
  SceneNumbers() = default;
  SceneNumbers(double number);
  SceneNumbers(std::initializer_list<double> numbers);
  template <class Derived>
  SceneNumbers(const Eigen::MatrixBase<Derived>& numbers) : text_(written(numbers)) {}

  /// As it stands in a scene.
  const std::string& text() const { return text_; }

 private:
  static std::string written(const Eigen::MatrixXd& numbers);

  std::string text_;
};

/// "x", "y" or "z", or components of any length but zero (three; in the plane two); of supports,
/// and of prescribed motion in the plane, "rotation" as well. Empty: not given.
class SceneDirection {
 public:
  SceneDirection() = default;
  SceneDirection(const char* word);
  SceneDirection(std::nullptr_t) = delete;  // which a component 0 on its own would be
  SceneDirection(std::initializer_list<double> components);
  template <class Derived>
  SceneDirection(const Eigen::MatrixBase<Derived>& components)
      : text_(SceneNumbers(components).text()) {}

  /// As it stands in a scene.
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// What of a node or an element a signal is: the direction along or about which, or the number of a
/// deformation. Empty: rotations in the plane, or deformation 1.
class SceneComponent {
 public:
  SceneComponent() = default;
  SceneComponent(int mode) : mode_(mode) {}
  SceneComponent(std::initializer_list<double> direction) : along_(direction) {}
  template <std::convertible_to<SceneDirection> Direction>
  SceneComponent(const Direction& direction) : along_(direction) {}

  const SceneDirection& along() const { return along_; }
  std::optional<int> mode() const { return mode_; }

 private:
  SceneDirection along_;
  std::optional<int> mode_;
};

struct TrussKeys {
  std::optional<double> stiffness = {};  ///< N/m, needed unless rigid
  std::optional<double> damping = {};    ///< N s/m
  std::optional<double> preload = {};    ///< N, tension positive
  bool rigid = false;
};

/// Of a beam in space, with six deformations, or in the plane, with three: there EI and shear, and
/// no orientation, GJ and inertia_per_length.
struct BeamKeys {
  SceneDirection orientation = {};
  std::optional<double> EA = {};                        ///< N
  std::optional<double> GJ = {};                        ///< N m^2
  std::optional<double> EI_y = {}, EI_z = {}, EI = {};  ///< N m^2
  std::optional<double> shear_y = {}, shear_z = {};     ///< N
  std::optional<double> shear = {};                     ///< N
  std::optional<double> mass_per_length = {};           ///< kg/m
  std::optional<double> inertia_per_length = {};        ///< kg m
  bool lumped_mass = false, second_order = false;
  SceneNumbers stiffness = {}, damping = {};  ///< besides the section's, N/m and N s/m
  std::optional<double> damping_time = {};    ///< s
  SceneNumbers rigid = {};                    ///< numbers of deformations, from 1
  SceneNumbers preload = {};                  ///< N
  std::optional<int> divide = {};             ///< into NAME/1 to NAME/N
};

struct HingeKeys {
  SceneDirection axis = {};                   ///< needed in space, none in the plane
  SceneNumbers rigid = {};                    ///< numbers of rotations; in space 2 and 3 by default
  bool ball = false;                          ///< none is rigid
  SceneNumbers stiffness = {}, damping = {};  ///< N m/rad, N m s/rad
  SceneNumbers preload = {};                  ///< N m
};

/// At the operating point; m, rad and their rates.
struct MotionKeys {
  std::optional<double> value = {}, rate = {}, acceleration = {};
};

/// Where a dof is in a scene as_written; m, rad and their rates.
struct StartKeys {
  std::optional<double> value = {}, rate = {};
};

/// One or both of force and torque, three components each; in the plane two and one.
struct LoadKeys {
  SceneNumbers force = {}, torque = {};  ///< N, N m
  bool follows = false;                  ///< turns with the node
};

struct FeedForwardKeys {
  std::optional<double> to_hz = {}, corner_hz = {}, target_hz = {}, damping_ratio = {};
  std::optional<double> at_most_db = {}, actuator_error = {}, noise_over_floor = {};
  std::optional<int> taps = {};
};

struct ControllerKeys {
  std::vector<std::string> legs = {};
  SceneNumbers target_hz = {}, damping_ratio = {};  ///< one, or one for each virtual mode
  std::optional<GainOrder> order = {};
  std::optional<Reduction> reduction = {};
  std::optional<Realisation> realisation = {};
  std::optional<double> sample_rate_hz = {}, delay_samples = {}, leak_hz = {}, high_pass_hz = {},
                        lead_samples = {}, roll_off_hz = {}, force_limit_n = {};
  std::optional<FeedForwardKeys> feed_forward = {};
  std::string law = {};  ///< path of a file; from the working folder
};

/// Puts a scene together call by call, in any order; its elements, dofs and signals are in the
/// order of the calls.
/// What it builds is a scene as a person would write it, which the reader then reads: what holds of
/// scene files holds of it, and its text can be saved and given to every program. Set-up.
class SceneBuilder {
 public:
  explicit SceneBuilder(const std::string& title);

  /// All motion in the x-y plane, rotations about z.
  SceneBuilder& planar();
  /// m/s^2, three components, in the plane two.
  SceneBuilder& gravity(const SceneNumbers& acceleration);
  /// One ratio, or rows of a frequency (Hz) and a ratio.
  SceneBuilder& modal_damping(const SceneNumbers& ratios);
  /// Looked at as it stands, and not in its equilibrium.
  SceneBuilder& as_written();

  /// position: m, three coordinates, in the plane two.
  SceneBuilder& node(const std::string& name, const SceneNumbers& position);
  /// mass: kg. inertia: kg m^2 about the node, three principal moments about the world axes or
  /// 3 x 3; in the plane one number.
  SceneBuilder& mass(const std::string& node, double mass, const SceneNumbers& inertia = {});

  SceneBuilder& truss(const std::string& name, const std::string& p, const std::string& q,
                      const TrussKeys& keys);
  SceneBuilder& beam(const std::string& name, const std::string& p, const std::string& q,
                     const BeamKeys& keys);
  SceneBuilder& rigid_beam(const std::string& name, const std::string& p, const std::string& q);
  SceneBuilder& hinge(const std::string& name, const std::string& p, const std::string& q,
                      const HingeKeys& keys = {});
  /// body: path of a body file, from the working folder; damping_time: s.
  SceneBuilder& superelement(const std::string& name, const std::vector<std::string>& nodes,
                             const std::string& body, std::optional<double> damping_time = {});

  /// Holds a node along directions that are perpendicular to each other.
  SceneBuilder& support(const std::string& node, const std::vector<SceneDirection>& fix);
  /// Moves a node along such directions.
  SceneBuilder& prescribe(const std::string& node, const std::vector<SceneDirection>& move,
                          const MotionKeys& motion = {});
  /// Moves a deformation of an element; mode from 1, needed of a beam.
  SceneBuilder& prescribe_element(const std::string& element, std::optional<int> mode = {},
                                  const MotionKeys& motion = {});

  /// One deformation of an element; mode from 1, needed of a beam.
  SceneBuilder& dof_of_element(const std::string& element, std::optional<int> mode = {},
                               const StartKeys& start = {});
  /// All deformations that are not rigid, of an element or of all parts of a divided beam.
  SceneBuilder& dofs_of(const std::string& element);
  SceneBuilder& dof_of_node(const std::string& node, const SceneDirection& along,
                            const StartKeys& start = {});
  /// Of a node in the plane.
  SceneBuilder& dof_of_rotation(const std::string& node, const StartKeys& start = {});
  /// parameter: 0 to 3, of a node in space.
  SceneBuilder& dof_of_euler_parameter(const std::string& node, int parameter,
                                       const StartKeys& start = {});
  /// The model chooses coordinates of nodes.
  SceneBuilder& automatic_dofs();

  SceneBuilder& load(const std::string& node, const LoadKeys& keys);

  /// of: a node or an element.
  SceneBuilder& input(const std::string& name, Quantity quantity, const std::string& of,
                      const SceneComponent& component = {});
  SceneBuilder& output(const std::string& name, Quantity quantity, const std::string& of,
                       const SceneComponent& component = {});
  /// Recorded, and no output.
  SceneBuilder& monitor(const std::string& name, Quantity quantity, const std::string& of,
                        const SceneComponent& component = {});

  SceneBuilder& controller(const ControllerKeys& keys);
  /// Any other block ("floor", "instruments", "compare" ...), as it would stand in a file.
  SceneBuilder& block(const std::string& key, const std::string& yaml);

  /// The scene; `text` of it is what a scene file would hold. Errors: InputError "scene
  /// builder:line:column: ..." of that text, with the key, what was found, what is allowed and the
  /// line, for whatever parse_scene refuses, and for what is given twice.
  Scene build() const;

 private:
  std::string text() const;

  std::string head_, nodes_, masses_, elements_, supports_, prescribed_, dofs_, loads_, inputs_,
      outputs_, monitors_, blocks_;
};

}  // namespace stillframe
