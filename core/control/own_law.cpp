#include "core/control/own_law.hpp"

#include <algorithm>
#include <optional>
#include <string_view>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/systems/sampled_loop.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

using Names = std::vector<std::string>;

std::string size_of(const MatrixXd& M) {
  return std::to_string(M.rows()) + " x " + std::to_string(M.cols());
}

void check_size(const char* name, const MatrixXd& M, Index rows, Index cols, const char* what) {
  if (M.rows() != rows || M.cols() != cols) {
    throw InputError(std::string(name) + ": found " + size_of(M) + ", allowed is " +
                     std::to_string(rows) + " x " + std::to_string(cols) + ", " + what);
  }
  if (!M.allFinite()) throw InputError(std::string(name) + ": found a number that is not finite");
}

std::string listed(const char* prefix, const Names& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + (prefix + name);
  return text;
}

/// Where a name without this prefix stands; nothing if it has another or is none of them.
std::optional<Index> place_in(const Names& names, const std::string& name, const char* prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  const auto found = std::find(names.begin(), names.end(), name.substr(std::string(prefix).size()));
  if (found == names.end()) return std::nullopt;
  return found - names.begin();
}

void check_once(const char* list, const Names& names) {
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (std::find(names.begin(), name, *name) != name) {
      throw InputError(std::string(list) + ": found \"" + *name + "\" twice");
    }
  }
}

[[noreturn]] void fail_input(const std::string& name, const Names& legs, const Names& floor) {
  if (name.starts_with("frame:")) {
    throw InputError("inputs: found \"" + name +
                     "\": a law hears no acceleration of the frame; allowed are "
                     "sigma:LEG, applied:LEG, strain_force:LEG and floor:NAME");
  }
  throw InputError("inputs: found \"" + name +
                   "\", which no measurement holds; allowed are sigma:, applied: or strain_force: "
                   "and a leg (" +
                   listed("", legs) + (floor.empty() ? ")" : "), " + listed(floor_prefix, floor)));
}

/// States that an input moves, or, of the transposed system, that move an output: by which entries
/// are zero, no more.
std::vector<bool> moved(const MatrixXd& A, const MatrixXd& B) {
  std::vector<bool> is(static_cast<size_t>(A.rows()));
  std::vector<Index> next;
  const auto add = [&](Index i) {
    if (is[static_cast<size_t>(i)]) return;
    is[static_cast<size_t>(i)] = true;
    next.push_back(i);
  };
  for (Index i = 0; i < A.rows(); ++i) {
    if (!B.row(i).isZero(0)) add(i);
  }
  while (!next.empty()) {
    const Index j = next.back();
    next.pop_back();
    for (Index i = 0; i < A.rows(); ++i) {
      if (A(i, j) != 0) add(i);
    }
  }
  return is;
}

/// The states that are moved and move, in their order.
LinearSystem without_idle_states(const LinearSystem& system) {
  const std::vector<bool> by_inputs = moved(system.A, system.B),
                          outputs = moved(system.A.transpose(), system.C.transpose());
  std::vector<Index> kept;
  for (Index i = 0; i < system.A.rows(); ++i) {
    if (by_inputs[static_cast<size_t>(i)] && outputs[static_cast<size_t>(i)]) kept.push_back(i);
  }
  return {.A = system.A(kept, kept),
          .B = system.B(kept, Eigen::all),
          .C = system.C(Eigen::all, kept),
          .D = system.D};
}

MatrixXd beside(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd out(a.rows(), a.cols() + b.cols());
  out << a, b;
  return out;
}

}  // namespace

bool hears_floor(const NamedLaw& law) {
  return std::any_of(law.inputs.begin(), law.inputs.end(),
                     [](const std::string& name) { return name.starts_with(floor_prefix); });
}

NamedLaw without_floor(const NamedLaw& law) {
  std::vector<Index> kept;
  NamedLaw out = law;
  out.inputs.clear();
  for (Index j = 0; j < std::ssize(law.inputs); ++j) {
    const std::string& name = law.inputs[static_cast<size_t>(j)];
    if (name.starts_with(floor_prefix)) continue;
    kept.push_back(j);
    out.inputs.push_back(name);
  }
  out.B = law.B(Eigen::all, kept);
  out.D = law.D(Eigen::all, kept);
  return out;
}

DiscreteLaw own_law(const NamedLaw& law, const Names& legs, const Names& floor) {
  const Index n = law.A.rows(), n_in = std::ssize(law.inputs), n_out = std::ssize(law.outputs);
  const Index m = std::ssize(legs), p = std::ssize(floor);
  check_size("A", law.A, n, n, "square");
  check_size("B", law.B, n, n_in, "a row for each state, a column for each of inputs");
  check_size("C", law.C, n_out, n, "a row for each of outputs, a column for each state");
  check_size("D", law.D, n_out, n_in, "a row for each of outputs, a column for each of inputs");
  check_once("inputs", law.inputs);
  check_once("outputs", law.outputs);

  MatrixXd C = MatrixXd::Zero(m, n), D_named = MatrixXd::Zero(m, n_in);
  for (Index i = 0; i < n_out; ++i) {
    const std::string& name = law.outputs[static_cast<size_t>(i)];
    const auto leg = place_in(legs, name, force_prefix);
    if (!leg) {
      throw InputError("outputs: found \"" + name +
                       "\", allowed is one for each leg: " + listed(force_prefix, legs));
    }
    C.row(*leg) = law.C.row(i);
    D_named.row(*leg) = law.D.row(i);
  }
  if (n_out != m) {
    throw InputError("outputs: found " + std::to_string(n_out) +
                     ", allowed is one for each leg: " + listed(force_prefix, legs));
  }

  // Columns: sigma, applied, floor.
  MatrixXd B = MatrixXd::Zero(n, 2 * m + p), D = MatrixXd::Zero(m, 2 * m + p);
  bool hears_applied = false;
  for (Index j = 0; j < n_in; ++j) {
    const std::string& name = law.inputs[static_cast<size_t>(j)];
    const auto hears = [&](Index column, double sign) {
      B.col(column) += sign * law.B.col(j);
      D.col(column) += sign * D_named.col(j);
    };
    if (const auto sigma = place_in(legs, name, sigma_prefix)) {
      hears(*sigma, 1);
    } else if (const auto applied = place_in(legs, name, applied_prefix)) {
      hears(m + *applied, 1);
      hears_applied = true;
    } else if (const auto strain = place_in(legs, name, strain_prefix)) {
      hears(*strain, 1);
      hears(m + *strain, -1);
      hears_applied = true;
    } else if (const auto acceleration = place_in(floor, name, floor_prefix)) {
      hears(2 * m + *acceleration, 1);
    } else {
      fail_input(name, legs, floor);
    }
  }

  const Index n_heard = hears_applied ? 2 * m : m;
  const LinearSystem feedback =
      without_idle_states({law.A, B.leftCols(n_heard), C, D.leftCols(n_heard)});
  DiscreteLaw out{.A = feedback.A,
                  .B = feedback.B,
                  .C = feedback.C,
                  .D = feedback.D,
                  .subtract_applied = false};
  if (!hears_floor(law)) return out;
  out.feed_forward = without_idle_states({law.A, B.rightCols(p), C, D.rightCols(p)});
  const double radius = spectral_radius(out.feed_forward.A);
  if (!(radius < largest_stable_radius)) {
    throw InputError("A: the states between the floor and the forces have a spectral radius of " +
                     formatted("%.9g", radius) +
                     ", below 1 is needed: what a law does with the floor has to decay by itself, "
                     "as it runs beside the feedback and before that takes hold");
  }
  return out;
}

NamedLaw named(const DiscreteLaw& law, const Names& legs, const Names& floor) {
  const Index m = std::ssize(legs), n = law.A.rows();
  const bool applied = law.subtract_applied || law.hears_applied(),
             filtered = law.subtract_applied && law.applied_memory > 0;
  const LinearSystem& forward = law.feed_forward;
  const Index n_r = filtered ? m : 0, p = forward.D.cols(), n_f = p > 0 ? forward.A.rows() : 0;
  NamedLaw out;
  const auto add = [&](const char* prefix, const Names& names) {
    for (const std::string& name : names) out.inputs.push_back(prefix + name);
  };
  add(sigma_prefix, legs);
  if (applied) add(applied_prefix, legs);
  if (p > 0) add(floor_prefix, floor);
  for (const std::string& leg : legs) out.outputs.push_back(force_prefix + leg);

  // e over (r of the sample before, sigma, applied).
  MatrixXd e_r = MatrixXd::Zero(law.D.cols(), n_r),
           e_in = MatrixXd::Identity(law.D.cols(), law.D.cols());
  if (law.subtract_applied) {
    const double a = law.applied_memory;
    e_in = beside(MatrixXd::Identity(m, m), -(1 - a) * MatrixXd::Identity(m, m));
    if (filtered) e_r = -a * MatrixXd::Identity(m, m);
  }
  const Index n_in = std::ssize(out.inputs), n_e = e_in.cols();
  out.A = MatrixXd::Zero(n + n_r + n_f, n + n_r + n_f);
  out.B = MatrixXd::Zero(n + n_r + n_f, n_in);
  out.C = MatrixXd::Zero(m, n + n_r + n_f);
  out.D = MatrixXd::Zero(m, n_in);
  out.A.topLeftCorner(n, n) = law.A;
  out.A.block(0, n, n, n_r) = law.B * e_r;
  out.B.topLeftCorner(n, n_e) = law.B * e_in;
  out.C.leftCols(n) = law.C;
  out.C.middleCols(n, n_r) = law.D * e_r;
  out.D.leftCols(n_e) = law.D * e_in;
  out.A.block(n, n, n_r, n_r).diagonal().setConstant(law.applied_memory);
  out.B.block(n, m, n_r, n_r).diagonal().setConstant(1 - law.applied_memory);
  if (p > 0) {
    out.A.bottomRightCorner(n_f, n_f) = forward.A;
    out.B.bottomRightCorner(n_f, p) = forward.B;
    out.C.rightCols(n_f) = forward.C;
    out.D.rightCols(p) = forward.D;
  }
  return out;
}

}  // namespace stillframe
