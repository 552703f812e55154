#include "core/mechanics/linearisation/signal_rows.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/elements/rotation.hpp"

namespace stillframe {

namespace {

bool is_rotational(Quantity quantity) { return traits_of(quantity).of == SignalOf::rotation; }

/// Of the values of a motion and of its two derivatives, that which a quantity measures.
template <class Value>
Value& of_order(Quantity quantity, Value& value, Value& rate, Value& acceleration) {
  Value* const values[] = {&value, &rate, &acceleration};
  return *values[traits_of(quantity).derivative];
}

ResolvedSignal resolve(const Model& model, const SceneSignal& signal) {
  ResolvedSignal result;
  result.quantity = signal.quantity;
  result.direction = signal.direction;
  result.place = signal.place;
  if (!signal.element.empty()) {
    result.row = model.deformation_row(signal.element, signal.mode);
    return result;
  }
  result.node = model.node_index(signal.node);
  const ModelNode& node = model.nodes[static_cast<size_t>(result.node)];
  if (is_rotational(signal.quantity) && !node.has_rotation()) {
    throw InputError(signal.place + ": node '" + signal.node +
                     "' has no rotation: no beam, no hinge and no inertia is attached to it");
  }
  return result;
}

/// The Euler parameters of a node in x; those of a fixed node are (1, 0, 0, 0).
Vector4 lambda_of(const ModelNode& node, const Eigen::VectorXd& x) {
  LocalVector delta;
  gather({node.rotation}, x, delta);
  return euler_parameters(delta);
}
/// Their rates, in x' or x''.
Vector4 rate_of(const ModelNode& node, const Eigen::VectorXd& x) {
  LocalVector rate;
  gather({node.rotation}, x, rate);
  return rate;
}

/// Puts the entries of a row of one rotation part in their columns, those below the row's size.
void place_rotation(const ModelNode& node, const Eigen::RowVectorXd& values,
                    Eigen::RowVectorXd& row) {
  for_each_column({node.rotation}, row.size(),
                  [&](Index i, Index column) { row(column) += values(i); });
}

Eigen::RowVectorXd rate_row(const Model& model, const ResolvedSignal& signal,
                            const Vector4& lambda) {
  if (model.planar) return Eigen::RowVectorXd::Ones(1);
  return 2.0 * signal.direction.transpose() * space_rate_matrix(lambda);
}

}  // namespace

ResolvedSignal resolve_input(const Model& model, const SceneSignal& input) {
  ResolvedSignal result = resolve(model, input);
  if (input.quantity == Quantity::stress && !model.is_elastic(result.row)) {
    throw InputError(input.place + ": deformation " + std::to_string(input.mode) + " of '" +
                     input.element + "' is rigid or prescribed; a driving stress there moves " +
                     "nothing");
  }
  return result;
}

ResolvedSignal resolve_output(const Model& model, const SceneSignal& output) {
  ResolvedSignal result = resolve(model, output);
  if (output.quantity == Quantity::stress) result.is_reaction = !model.is_elastic(result.row);
  if (output.quantity != Quantity::reaction && output.quantity != Quantity::reaction_moment) {
    return result;
  }
  result.is_reaction = true;
  const Eigen::VectorXd motion = virtual_motion(model, Eigen::VectorXd::Zero(model.n_x), result);
  // What holds are the prescribed and the fixed coordinates; 1e-9 as in prescribed_pattern.
  if (motion.head(model.n_x - model.n_rx).norm() > 1e-9 * motion.norm()) {
    throw InputError(output.place + ": node '" + output.node +
                     "' is neither supported nor prescribed " +
                     (output.quantity == Quantity::reaction ? "along" : "about") +
                     " this direction, so that there is no reaction");
  }
  return result;
}

Eigen::VectorXd unit_force(const Model& model, const Eigen::VectorXd& x,
                           const ResolvedSignal& signal) {
  if (!is_rotational(signal.quantity)) {
    return model.full_translation_row(signal.node, signal.direction).transpose();
  }
  const ModelNode& node = model.nodes[static_cast<size_t>(signal.node)];
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(model.n_x + model.n_0);
  const Vector4 lambda = model.planar ? Vector4::Zero() : lambda_of(node, x);
  place_rotation(node, rate_row(model, signal, lambda), row);
  return row.transpose();
}

Eigen::VectorXd virtual_motion(const Model& model, const Eigen::VectorXd& x,
                               const ResolvedSignal& signal) {
  // omega = 2 Lambda_s lambda' and Lambda_s Lambda_s^T = I.
  const bool of_euler_parameters = is_rotational(signal.quantity) && !model.planar;
  return (of_euler_parameters ? 0.25 : 1.0) * unit_force(model, x, signal);
}

KinematicRows kinematic_rows(const Model& model, const Data& data, const ResolvedSignal& output) {
  const Eigen::RowVectorXd zero = Eigen::RowVectorXd::Zero(model.n_x);
  KinematicRows rows{zero, zero, zero};
  Eigen::RowVectorXd& own = of_order(output.quantity, rows.p, rows.v, rows.a);
  if (!is_rotational(output.quantity)) {
    own = model.translation_row(output.node, output.direction);
    return rows;
  }
  const ModelNode& node = model.nodes[static_cast<size_t>(output.node)];
  const auto place = [&](const Vector4& lambda, double sign, Eigen::RowVectorXd& row) {
    place_rotation(node, sign * rate_row(model, output, lambda), row);
  };
  const Vector4 lambda = model.planar ? Vector4::Zero() : lambda_of(node, data.x);
  // Lambda_s(a) b = -Lambda_s(b) a, so omega and omega' change with lambda by -2 Lambda_s(lambda')
  // and -2 Lambda_s(lambda'').
  place(lambda, 1.0, own);
  if (output.quantity != Quantity::rotation && !model.planar) {
    place(rate_of(node, of_order(output.quantity, data.x, data.x_dot, data.x_ddot)), -1.0, rows.p);
  }
  return rows;
}

namespace {

double rotational_output(const Model& model, const Data& data, const ResolvedSignal& output,
                         const Eigen::VectorXd& x_reference) {
  const ModelNode& node = model.nodes[static_cast<size_t>(output.node)];
  const Eigen::VectorXd& x = of_order(output.quantity, data.x, data.x_dot, data.x_ddot);
  LocalVector part;
  gather({node.rotation}, x, part);
  if (model.planar) return part(0);
  if (output.quantity != Quantity::rotation) {
    return rate_row(model, output, lambda_of(node, data.x)).dot(part);
  }
  return rate_row(model, output, lambda_of(node, x_reference)).dot(lambda_of(node, data.x));
}

/// e'' = D x'' + D2_x(x', x').
double deformation_acceleration(const Model& model, const Data& data, Index row) {
  const auto [k, i] = model.owner_of_row(row);
  const ModelElement& item = model.elements[k];
  LocalVector u, rate, acceleration;
  LocalDeformation second(data.D[k].rows());
  gather(item.parts, data.x, u);
  gather(item.parts, data.x_dot, rate);
  gather_in_node_axes(item.parts, data.x_ddot, acceleration);
  item.element->second_derivative(u, rate, rate, second);
  return data.D[k].row(i).dot(acceleration) + second(i);
}

}  // namespace

Eigen::VectorXd nonlinear_outputs(const Model& model, const Data& data,
                                  const std::vector<ResolvedSignal>& outputs,
                                  const Eigen::VectorXd& x_reference) {
  Eigen::VectorXd y(static_cast<Index>(outputs.size())), constraint;
  for (size_t i = 0; i < outputs.size(); ++i) {
    const ResolvedSignal& output = outputs[i];
    double& value = y(static_cast<Index>(i));
    switch (output.quantity) {
      case Quantity::position:
      case Quantity::velocity:
      case Quantity::acceleration:
        value = model.translation_row(output.node, output.direction)
                    .dot(of_order(output.quantity, data.x, data.x_dot, data.x_ddot));
        break;
      case Quantity::stress:
        value = data.sigma(output.row);
        break;
      case Quantity::deformation:
        value = data.e(output.row);
        break;
      case Quantity::deformation_rate:
        value = data.e_dot(output.row);
        break;
      case Quantity::deformation_acceleration:
        value = deformation_acceleration(model, data, output.row);
        break;
      case Quantity::reaction:
      case Quantity::reaction_moment:
        if (constraint.size() == 0) constraint = constraint_forces(model, data);
        value = virtual_motion(model, data.x, output).dot(constraint);
        break;
      default:
        value = rotational_output(model, data, output, x_reference);
    }
  }
  return y;
}

}  // namespace stillframe
