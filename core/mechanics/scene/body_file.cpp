#include "core/mechanics/scene/body_file.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/files/matrix_market.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/inertia/superelement_mass.hpp"
#include "core/mechanics/scene/references.hpp"
#include "core/yaml/quoted.hpp"

namespace stillframe {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Text with ten digits, as other programs write matrices, leaves 1e-10 of each entry; a reduction
/// loses some digits more. A forgotten interface or a wrong unit is off by all of it.
constexpr double body_known_to = 1e-6;
/// More than the digits of a data sheet, less than a part that was forgotten.
constexpr double stated_to = 1e-3;

Matrix3Xd from_first(const Matrix3Xd& points) { return points.colwise() - points.col(0); }

/// Scaled by the square roots of the diagonal, so that metres and radians compare.
MatrixXd balanced(const MatrixXd& matrix, VectorXd& scale) {
  scale = matrix.diagonal().cwiseAbs().cwiseSqrt();
  scale = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 1.0; });
  return scale.asDiagonal() * matrix * scale.asDiagonal();
}

MatrixXd read_square(const YamlReader& value, Index size, std::vector<ReadFile>& files) {
  constexpr std::size_t most = std::size_t{64} << 20;
  const auto [path, text] = value.file_bytes(most);
  const Eigen::SparseMatrix<double> read = parse_matrix_market(text, path.string());
  if (read.rows() != size || read.cols() != size) {
    value.fail("the matrix of '" + path.string() + "' is " + std::to_string(read.rows()) + " x " +
               std::to_string(read.cols()) + ", but 6 an interface and 1 a mode are " +
               std::to_string(size));
  }
  MatrixXd matrix(read);
  VectorXd scale;
  const MatrixXd compared = balanced(matrix, scale);
  Index i = 0, j = 0;
  const double off = (compared - compared.transpose()).cwiseAbs().maxCoeff(&i, &j);
  if (!(off <= body_known_to)) {
    value.fail("the matrix of '" + path.string() + "' is not symmetric: entry (" +
               std::to_string(i + 1) + ", " + std::to_string(j + 1) + ") is " +
               shown(matrix(i, j)) + " and its mirror image " + shown(matrix(j, i)));
  }
  files.push_back({path.string(), text});
  return 0.5 * (matrix + matrix.transpose());
}

/// That of the diagonal of K, but of no entry less than a ten-thousandth of the largest: what has
/// hardly any stiffness, as a single interface, is not measured by its rounding. Between metres and
/// radians is the size of the body.
VectorXd against_largest(const FlexibleBody& body) {
  const Eigen::Matrix<double, 6, 6> rigid = rigid_mass(from_first(body.points), body.M);
  const double gyration = rigid.bottomRightCorner<3, 3>().trace() / rigid(0, 0),
               square = gyration > 0 && std::isfinite(gyration) ? gyration : 1.0;
  VectorXd lengths = VectorXd::Ones(body.K.rows());
  for (Index k = 0; k < body.points.cols(); ++k) lengths.segment<3>(6 * k + 3).setConstant(square);
  const VectorXd diagonal = body.K.diagonal().cwiseAbs();
  const double largest = diagonal.cwiseQuotient(lengths).maxCoeff();
  const VectorXd least = 1e-4 * largest * lengths;
  return diagonal.cwiseMax(least).unaryExpr(
      [](double k) { return k > 0 ? 1 / std::sqrt(k) : 1.0; });
}

}  // namespace

std::string stiffness_fault(const FlexibleBody& body) {
  const MatrixXd E = rigid_motions(from_first(body.points), body.n_modes);
  const VectorXd scale = against_largest(body);
  const MatrixXd K = scale.asDiagonal() * body.K * scale.asDiagonal();
  static constexpr const char* names[] = {"translation along x", "translation along y",
                                          "translation along z", "turn about x",
                                          "turn about y",        "turn about z"};
  for (Index i = 0; i < 6; ++i) {
    const VectorXd motion = scale.cwiseInverse().asDiagonal() * E.col(i);
    const double off = (K * motion).cwiseAbs().maxCoeff() / motion.cwiseAbs().maxCoeff();
    if (!(off <= body_known_to)) {
      return "the body resists a rigid " + std::string(names[i]) + " (by " + shown(off) +
             " of its largest stiffness, allowed is " + shown(body_known_to) +
             "): is it held somewhere, or are the positions of its interfaces in other units?";
    }
  }
  const Index n_e = body.K.rows() - 6;
  if (n_e == 0) return "one interface and no modes: that is a rigid body, see masses";
  VectorXd own;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(
      balanced(body.K.bottomRightCorner(n_e, n_e), own), Eigen::EigenvaluesOnly);
  // What is softer than the digits of K is no stiffness.
  if (solver.eigenvalues()(0) > 1e-12) return "";
  return "with its first interface held the body can still move without stiffness, or with a "
         "negative one";
}

std::string mass_fault(const FlexibleBody& body) {
  VectorXd scale;
  const MatrixXd M = balanced(body.M, scale);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(M, Eigen::EigenvaluesOnly);
  if (!(solver.eigenvalues()(0) >= -body_known_to)) {
    return "the mass matrix is indefinite: its smallest eigenvalue, scaled, is " +
           shown(solver.eigenvalues()(0));
  }
  const Eigen::Matrix<double, 6, 6> rigid = rigid_mass(from_first(body.points), body.M);
  const Matrix3d mass = rigid.topLeftCorner<3, 3>(), moment = rigid.topRightCorner<3, 3>();
  const double m = mass.trace() / 3;
  if (!(m > 0)) return "the body has no mass";
  const double off_mass = (mass - m * Matrix3d::Identity()).cwiseAbs().maxCoeff() / m;
  const double size = std::sqrt(std::max(rigid.bottomRightCorner<3, 3>().trace(), 0.0) / m);
  const double off_moment = (moment + moment.transpose()).cwiseAbs().maxCoeff() / (m * size);
  if (off_mass <= body_known_to && off_moment <= body_known_to) return "";
  return "the mass is not the same in all directions (off by " +
         shown(std::max(off_mass, off_moment)) + ", allowed is " + shown(body_known_to) +
         "): is it the matrix of these interfaces, in kg and m?";
}

namespace {

/// Keys that say what the body has to be.
void check_stated(const YamlReader& map, const FlexibleBody& body) {
  const RigidProperties found = rigid_properties(body);
  if (const auto given = map.find("mass")) {
    if (!(std::abs(given->positive() - found.mass) <= stated_to * found.mass)) {
      given->fail("found " + given->text() + ", but the mass matrix has " + shown(found.mass) +
                  " kg");
    }
  }
  const double size = std::sqrt(found.inertia.trace() / found.mass);
  const auto numbers = [](const auto& matrix) {
    std::string text;
    for (Index i = 0; i < matrix.size(); ++i) text += (i ? ", " : "") + shown(matrix(i));
    return "[" + text + "]";
  };
  if (const auto given = map.find("centre_of_mass")) {
    if (!((given->vector(3) - found.centre).norm() <= stated_to * size)) {
      given->fail("the mass matrix has its centre of mass at " + numbers(found.centre) + " m");
    }
  }
  if (const auto given = map.find("inertia")) {
    if (!((given->matrix(3, 3) - found.inertia).norm() <= stated_to * found.inertia.norm())) {
      given->fail("the mass matrix has, about its centre of mass, the rows " +
                  numbers(found.inertia) + " kg m^2");
    }
  }
}

}  // namespace

RigidProperties rigid_properties(const FlexibleBody& body) {
  const Eigen::Matrix<double, 6, 6> rigid = rigid_mass(from_first(body.points), body.M);
  RigidProperties found;
  found.mass = rigid.topLeftCorner<3, 3>().trace() / 3;
  // Of a turn omega the momentum is -[m c]x omega.
  const Matrix3d moment = rigid.topRightCorner<3, 3>();
  const Vector3 c = 0.5 / found.mass *
                    Vector3(moment(1, 2) - moment(2, 1), moment(2, 0) - moment(0, 2),
                            moment(0, 1) - moment(1, 0));
  found.centre = body.points.col(0) + c;
  const Matrix3d across = cross_matrix(c);
  found.inertia = rigid.bottomRightCorner<3, 3>() + found.mass * across * across;
  return found;
}

FlexibleBody read_flexible_body(const YamlReader& path, std::vector<ReadFile>& files) {
  constexpr std::size_t most = std::size_t{1} << 20;
  const auto [file, text] = path.file_bytes(most);
  const YamlReader map = YamlReader::from_text(text, file.string(), file.parent_path());
  files.push_back({file.string(), text});
  map.allow_only({"title", "interfaces", "modes", "mass_matrix", "stiffness_matrix", "mass",
                  "centre_of_mass", "inertia"});
  FlexibleBody body;
  const YamlReader interfaces = map.require("interfaces");
  const auto entries = interfaces.entries();
  if (entries.empty()) interfaces.fail("at least one is needed");
  body.points.resize(3, static_cast<Index>(entries.size()));
  for (const auto& [name, value] : entries) {
    body.points.col(static_cast<Index>(body.interfaces.size())) = value.vector(3);
    body.interfaces.push_back(name);
  }
  if (const auto modes = map.find("modes")) body.n_modes = modes->integer(0);
  if (body.n_modes > max_deformations || body.points.cols() > max_local / 7) {
    throw InputError(file.string() + ": " + std::to_string(body.points.cols()) +
                     " interfaces and " + std::to_string(body.n_modes) + " modes are too many");
  }
  const Index size = 6 * body.points.cols() + body.n_modes;
  const YamlReader mass = map.require("mass_matrix"), stiffness = map.require("stiffness_matrix");
  body.M = read_square(mass, size, files);
  body.K = read_square(stiffness, size, files);
  if (const auto why = stiffness_fault(body); !why.empty()) stiffness.fail(why);
  if (const auto why = mass_fault(body); !why.empty()) mass.fail(why);
  check_stated(map, body);
  return body;
}

std::string flexible_body_text(const FlexibleBody& body, const std::string& title,
                               const std::string& mass_file, const std::string& stiffness_file) {
  const RigidProperties rigid = rigid_properties(body);
  const auto vector = [](const auto& v) {
    return "[" + shortest_digits(v(0)) + ", " + shortest_digits(v(1)) + ", " +
           shortest_digits(v(2)) + "]";
  };
  std::string text = "title: " + quoted(title) + "\n";
  text +=
      "# The matrices have, of each of these in turn, displacements (m) and small rotations\n"
      "# (rad) along and about x, y, z, and then the amplitudes of the modes (m).\n"
      "interfaces:\n";
  for (std::size_t k = 0; k < body.interfaces.size(); ++k) {
    text +=
        "  " + body.interfaces[k] + ": " + vector(body.points.col(static_cast<Index>(k))) + "\n";
  }
  text += "modes: " + std::to_string(body.n_modes) + "\n";
  text +=
      "mass_matrix: " + quoted(mass_file) + "\nstiffness_matrix: " + quoted(stiffness_file) + "\n";
  text += "# Of the mass matrix; refused if it is another.\n";
  text += "mass: " + shortest_digits(rigid.mass) + "\n";
  text += "centre_of_mass: " + vector(rigid.centre) + "\n";
  text += "inertia: [" + vector(rigid.inertia.row(0)) + ", " + vector(rigid.inertia.row(1)) + ", " +
          vector(rigid.inertia.row(2)) + "]\n";
  return text;
}

}  // namespace stillframe
