#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/errors/input_error.hpp"
#include "core/files/matrix_market.hpp"
#include "core/mechanics/certificate.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/elements/superelement.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/inertia/superelement_mass.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/body_file.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Masses in a row of points whose displacements are N times the interfaces' and the modes': exact
/// in rigid motion, anything else in the rest.
struct Cloud {
  static constexpr Index n_modes = 2, n_points = 30;
  Matrix3Xd s{3, 3}, at{3, n_points};
  std::vector<MatrixXd> N;
  VectorXd masses;
  MatrixXd M;

  explicit Cloud(unsigned seed) {
    std::mt19937 engine(seed);
    s << Vector3d::Zero(), random_vector(3, engine), random_vector(3, engine);
    const MatrixXd E = rigid_motions(s, n_modes);
    const MatrixXd inverse = (E.transpose() * E).inverse() * E.transpose();
    masses = random_vector(n_points, engine).cwiseAbs();
    M.setZero(E.rows(), E.rows());
    for (Index i = 0; i < n_points; ++i) {
      at.col(i) = random_vector(3, engine);
      MatrixXd rigid(3, 6);
      rigid << Matrix3d::Identity(), -cross_matrix(at.col(i));
      const MatrixXd any = random_vector(3 * E.rows(), engine).reshaped(3, E.rows());
      N.push_back(rigid * inverse + any - any * E * inverse);
      M += masses(i) * N.back().transpose() * N.back();
    }
  }
  Superelement element() const { return Superelement({0, 1, 2}, s, {3}, n_modes); }
  double mass() const { return masses.sum(); }
};

constexpr Index n_local = 24;  // three nodes and one whose translations are amplitudes

TEST(Superelement, IsAsManyOfTwoInterfacesAndTheAmplitudesThemselves) {
  std::mt19937 engine(5);
  const Cloud cloud(3);
  const Superelement whole = cloud.element();
  ASSERT_EQ(whole.n_deformations(), 14);
  ASSERT_EQ(whole.n_local(), n_local);
  for (int trial = 0; trial < 10; ++trial) {
    const LocalVector u = random_vector(n_local, engine), v = random_vector(n_local, engine),
                      a = random_vector(n_local, engine);
    LocalDeformation e(14), second(14);
    LocalJacobian D(14, n_local), rate(14, n_local), second_rate(14, n_local);
    LocalHessian H(n_local, n_local);
    const LocalDeformation sigma = random_vector(14, engine);
    whole.deformations(u, e);
    whole.jacobian(u, D);
    whole.second_derivative(u, v, a, second);
    whole.jacobian_rates(u, v, a, rate, second_rate);
    whole.hessian(u, sigma, H);
    LocalHessian sum = LocalHessian::Zero(n_local, n_local);
    for (Index k = 1; k < 3; ++k) {
      Matrix3Xd s(3, 2);
      s << Vector3d::Zero(), cloud.s.col(k);
      const Superelement pair({0, 1}, s, {}, 0);
      const auto part = [&](const LocalVector& all) {
        LocalVector two(14);
        two << all.head<7>(), all.segment<7>(7 * k);
        return two;
      };
      LocalDeformation e_2(6), second_2(6);
      LocalJacobian D_2(6, 14), rate_2(6, 14), second_rate_2(6, 14);
      LocalHessian H_2(14, 14);
      pair.deformations(part(u), e_2);
      pair.jacobian(part(u), D_2);
      pair.second_derivative(part(u), part(v), part(a), second_2);
      pair.jacobian_rates(part(u), part(v), part(a), rate_2, second_rate_2);
      pair.hessian(part(u), sigma.segment(6 * (k - 1), 6), H_2);
      const Index row = 6 * (k - 1), column = 7 * k;
      EXPECT_EQ((e.segment(row, 6) - e_2).norm(), 0);
      EXPECT_EQ((second.segment(row, 6) - second_2).norm(), 0);
      for (const auto& [all, two] : {std::pair(&D, &D_2), std::pair(&rate, &rate_2),
                                     std::pair(&second_rate, &second_rate_2)}) {
        EXPECT_EQ((all->block(row, 0, 6, 7) - two->leftCols(7)).norm(), 0);
        EXPECT_EQ((all->block(row, column, 6, 7) - two->rightCols(7)).norm(), 0);
        EXPECT_EQ(all->block(row, 7 * (3 - k), 6, 7).norm(), 0);
        EXPECT_EQ(all->rightCols(3).topRows(12).norm(), 0);
      }
      sum.topLeftCorner(7, 7) += H_2.topLeftCorner(7, 7);
      sum.block(0, column, 7, 7) += H_2.topRightCorner(7, 7);
      sum.block(column, 0, 7, 7) += H_2.bottomLeftCorner(7, 7);
      sum.block(column, column, 7, 7) += H_2.bottomRightCorner(7, 7);
    }
    // Two sums in another order.
    EXPECT_LE(worst_of(MatrixXd(H - sum)), 1e-14 * worst_of(MatrixXd(sum)));
    EXPECT_EQ((e.tail(2) - u.segment(21, 2)).norm(), 0);
    EXPECT_EQ((D.bottomRightCorner(2, 3) - MatrixXd::Identity(2, 3)).norm(), 0);
    EXPECT_EQ(second.tail(2).norm() + rate.bottomRows(2).norm(), 0);
  }
}

/// Displacements and rates of a rigid motion: turn lambda about the first node, which moves by t.
struct RigidMotion {
  LocalVector u = LocalVector::Zero(n_local), v = u, a = u;
  Matrix3d R;
  Vector3d t, velocity, omega;  ///< omega in body axes

  RigidMotion(const Cloud& cloud, std::mt19937& engine)
      : t(random_vector(3, engine)),
        velocity(random_vector(3, engine)),
        omega(random_vector(3, engine)) {
    const Vector4 lambda = random_vector(4, engine).normalized();
    R = Eigen::Quaterniond(lambda(0), lambda(1), lambda(2), lambda(3)).toRotationMatrix();
    for (Index k = 0; k < 3; ++k) {
      const Vector3d s = cloud.s.col(k);
      u.segment<3>(7 * k) = t + R * s - s;
      u.segment<4>(7 * k + 3) = lambda - Vector4::Unit(0);
      v.segment<3>(7 * k) = velocity + R * omega.cross(s);
      v.segment<4>(7 * k + 3) = 0.5 * body_rate_matrix(lambda).transpose() * omega;
    }
  }
};

TEST(SuperelementMass, InARigidMotionOfAnySizeItIsItsPoints) {
  std::mt19937 engine(11);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Cloud cloud(seed);
    const SuperelementMass mass(cloud.element(), cloud.s, cloud.M);
    const RigidMotion motion(cloud, engine);
    const Vector3d g = random_vector(3, engine);
    double kinetic = 0, potential = 0;
    Vector3d force = Vector3d::Zero();  // to keep the motion up without accelerations of u''
    for (Index i = 0; i < Cloud::n_points; ++i) {
      const Vector3d x = cloud.at.col(i);
      const Vector3d rate = motion.velocity + motion.R * motion.omega.cross(x);
      kinetic += 0.5 * cloud.masses(i) * rate.squaredNorm();
      potential -= cloud.masses(i) * g.dot(motion.t + motion.R * x - x);
      force += cloud.masses(i) * (motion.R * motion.omega.cross(motion.omega.cross(x)) - g);
    }
    // Sums of thirty products of numbers of size one.
    EXPECT_NEAR(mass.kinetic_energy(motion.u, motion.v), kinetic, 1e-13 * kinetic);
    EXPECT_NEAR(mass.gravity_energy(motion.u, g), potential, 1e-12 * cloud.mass());
    // A steady turn about the first node: u'' of the others is centripetal, and of the Euler
    // parameters what keeps their norm.
    LocalVector a = LocalVector::Zero(n_local), F(n_local);
    for (Index k = 0; k < 3; ++k) {
      a.segment<3>(7 * k) =
          motion.R * motion.omega.cross(motion.omega.cross(Vector3d(cloud.s.col(k))));
      const Vector4 lambda = euler_parameters(motion.u.segment<4>(7 * k + 3));
      a.segment<4>(7 * k + 3) = -lambda * motion.v.segment<4>(7 * k + 3).squaredNorm();
    }
    mass.force(motion.u, motion.v, a, g, F);
    Vector3d sum = Vector3d::Zero();
    for (Index k = 0; k < 3; ++k) sum += F.segment<3>(7 * k);
    EXPECT_LE((sum - force).norm(), 1e-12 * cloud.mass());
  }
}

TEST(SuperelementMass, WeightPullsAtThePointsOfTheDeformedBody) {
  std::mt19937 engine(13);
  const Cloud cloud(7);
  const SuperelementMass mass(cloud.element(), cloud.s, cloud.M);
  const RigidMotion motion(cloud, engine);
  const Vector3d g = random_vector(3, engine);
  // Small displacements on top of the large motion, in its frame: V is linear in them.
  const VectorXd small = random_vector(20, engine);
  const auto energy = [&](double h) {
    LocalVector u = motion.u;
    for (Index k = 0; k < 3; ++k) {
      u.segment<3>(7 * k) += motion.R * (h * small.segment<3>(6 * k));
      const Vector4 lambda = euler_parameters(u.segment<4>(7 * k + 3));
      u.segment<4>(7 * k + 3) +=
          0.5 * body_rate_matrix(lambda).transpose() * (h * small.segment<3>(6 * k + 3));
    }
    u.segment(21, 2) = h * small.tail(2);
    return VectorXd::Constant(1, mass.gravity_energy(u, g));
  };
  double expected = 0;
  for (Index i = 0; i < Cloud::n_points; ++i) {
    expected -= cloud.masses(i) * g.dot(motion.R * (cloud.N[static_cast<size_t>(i)] * small));
  }
  // Extrapolated differences with this step leave 8 eps / h of rounding.
  EXPECT_NEAR(derivative(energy, 0.01)(0), expected, 1e-11 * cloud.mass());
}

std::string body_of(const std::string& mass, const std::string& stiffness) {
  return "interfaces: {a: [0, 0, 0], b: [1, 0, 0]}\nmass_matrix: " + mass +
         "\nstiffness_matrix: " + stiffness + "\n";
}

/// A uniform beam of length 1 as its consistent matrices, of the books: bars, shafts and Hermite's
/// cubics.
struct BookBeam {
  MatrixXd M = MatrixXd::Zero(12, 12), K = M;
  static constexpr double m = 2.0, J = 0.01, EA = 1e5, GJ = 40, EI_y = 30, EI_z = 50;

  BookBeam() {
    // Along the axis as the scene's beams have it: a cubic whose end slopes stay.
    pair(0, m / 420 * 156, m / 420 * 54, EA);
    pair(3, J / 6 * 2, J / 6, GJ);
    bend(1, 5, 1, EI_z);
    bend(2, 4, -1, EI_y);
  }

 private:
  void pair(Index i, double own, double other, double stiffness) {
    for (const Index a : {i, i + 6}) {
      for (const Index b : {i, i + 6}) {
        M(a, b) = a == b ? own : other;
        K(a, b) = a == b ? stiffness : -stiffness;
      }
    }
  }
  void bend(Index w, Index turn, double sign, double EI) {
    const Index at[] = {w, turn, w + 6, turn + 6};
    const double s[] = {1, sign, 1, sign};
    Eigen::Matrix4d mass, stiffness;
    mass << 156, 22, 54, -13, 22, 4, 13, -3, 54, 13, 156, -22, -13, -3, -22, 4;
    stiffness << 12, 6, -12, 6, 6, 4, -6, 2, -12, -6, 12, -6, 6, 2, -6, 4;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        M(at[i], at[j]) += m / 420 * s[i] * s[j] * mass(i, j);
        K(at[i], at[j]) += EI * s[i] * s[j] * stiffness(i, j);
      }
    }
  }
};

class BodyFiles : public testing::Test {
 protected:
  void write(const MatrixXd& M, const MatrixXd& K) const {
    folder_.write("M.mtx", matrix_market(M, "M"));
    folder_.write("K.mtx", matrix_market(K, "K"));
    folder_.write("body.yaml", body_of("M.mtx", "K.mtx"));
  }
  std::string refusal() const {
    std::vector<ReadFile> files;
    try {
      read_flexible_body(YamlReader::from_text((folder_ / "body.yaml").string(), "scene"), files);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  Scene scene(const std::string& element, const std::string& rest, const Matrix3d& R,
              const Vector3d& t) const {
    const auto text = [](const Vector3d& v) {
      return "[" + shortest_digits(v.x()) + ", " + shortest_digits(v.y()) + ", " +
             shortest_digits(v.z()) + "]";
    };
    return parse_scene(
        "title: beam\nnodes: {p: {position: " + text(t) + "}, q: {position: " + text(t + R.col(0)) +
            "}}\nmasses: [{node: q, mass: 0.5, inertia: [1, " +
            "1, 1]}]\nelements: {beam: {nodes: [p, q], " + element + "}}\ndofs: auto\n" + rest,
        "scene.yaml");
  }
  std::string superelement() const {
    return "type: superelement, body: " + (folder_ / "body.yaml").string();
  }
  static std::string beam(const Vector3d& y) {
    return "type: beam, EA: 1e5, GJ: 40, EI_y: 30, EI_z: 50, mass_per_length: 2, "
           "inertia_per_length: 0.01, orientation: [" +
           shortest_digits(y.x()) + ", " + shortest_digits(y.y()) + ", " + shortest_digits(y.z()) +
           "]";
  }
  const ScratchFolder folder_;
};

VectorXd frequencies(const Scene& scene) {
  return modes(linearise(scene, make_model(scene), {}, {})).natural_frequencies_hz;
}

TEST_F(BodyFiles, ABeamOfTheBooksIsTheBeamOfTheScene) {
  const BookBeam book;
  write(book.M, book.K);
  const std::string held = "supports: [{nodes: [p], fix: [x, y, z, rotation]}]\n";
  // Along x its matrices need not be turned, and two interfaces do not say how they would be.
  const Vector3d t(0.3, -0.2, 1);
  for (const std::string& rest : {std::string(), held}) {
    const VectorXd expected =
                       frequencies(scene(beam(Vector3d::UnitY()), rest, Matrix3d::Identity(), t)),
                   found = frequencies(scene(superelement(), rest, Matrix3d::Identity(), t));
    ASSERT_EQ(found.size(), expected.size());
    // Rounding of the highest, which rigid modes show.
    for (Index i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found(i) * found(i), expected(i) * expected(i), 1e-13 * expected.squaredNorm())
          << i;
    }
  }
}

TEST_F(BodyFiles, UnderWeightItBendsAndIsHeldAsTheBeamIs) {
  const BookBeam book;
  write(book.M, book.K);
  // Little weight: to first order in it the two are one.
  const std::string rest =
      "gravity: [0.001, -0.002, -0.001]\nsupports: [{nodes: [p], fix: [x, y, z, rotation]}]\n";
  const Scene one = scene(beam(Vector3d::UnitY()), rest, Matrix3d::Identity(), Vector3d::Zero()),
              other = scene(superelement(), rest, Matrix3d::Identity(), Vector3d::Zero());
  const Model beam_model = make_model(one), model = make_model(other);
  const VectorXd x = nominal_motion(model).state.q_d, y = nominal_motion(beam_model).state.q_d;
  ASSERT_EQ(x.size(), y.size());
  EXPECT_LE(worst_of(x - y), 2e-4 * worst_of(y));
  EXPECT_GT(worst_of(y), 1e-6);
}

TEST_F(BodyFiles, IsCertifiedInMotion) {
  const BookBeam book;
  write(book.M, book.K);
  // A spinning table carries the body, off its axis, under gravity, and turns ever faster.
  std::string dofs;
  for (int mode = 1; mode <= 6; ++mode) {
    dofs += "- {element: beam, mode: " + std::to_string(mode) +
            ", value: " + std::to_string(0.01 * mode) +
            ", rate: " + std::to_string(0.3 - 0.1 * mode) + "}\n";
  }
  const Scene scene = parse_scene(
      "title: spinning\ngravity: [0, 0, -9.81]\noperating_point: as_written\nnodes:\n"
      "  o: {position: [0, 0, 0]}\n  t: {position: [0, 0, 0]}\n  p: {position: [0.4, 0.1, 0]}\n"
      "  q: {position: [1.4, 0.1, 0]}\nmasses: [{node: q, mass: 0.5, inertia: [1, 2, 1.5]}]\n"
      "elements:\n  motor: {type: hinge, nodes: [o, t], axis: [0.3, 0.1, 1]}\n"
      "  arm: {type: rigid_beam, nodes: [t, p]}\n"
      "  beam: {nodes: [p, q], damping_time: 1e-3, " +
          superelement() +
          "}\n"
          "supports: [{nodes: [o], fix: [x, y, z, rotation]}]\n"
          "prescribed: [{element: motor, value: 0.4, rate: 2, acceleration: 3}]\n"
          "dofs:\n" +
          dofs +
          "inputs: [{name: f, force: q, along: y}, {name: m, deformation_acceleration: motor}]\n"
          "outputs: [{name: y, position: q, along: y}, {name: s, stress: beam, mode: 3}]\n",
      "spinning.yaml");
  const auto blocks = certify(scene);
  EXPECT_GE(blocks.size(), 10u);
  for (const BlockCertificate& block : blocks) {
    EXPECT_TRUE(is_certified(block)) << block.block << " " << block.difference;
    EXPECT_TRUE(block.size > 0 || block.block == "D_y") << block.block;
  }
}

TEST_F(BodyFiles, MayStandTurnedInAnyWay) {
  // Three interfaces: two beams at a right angle, as one body.
  const BookBeam book;
  const Matrix3d quarter = Eigen::AngleAxisd(EIGEN_PI / 2, Vector3d::UnitZ()).toRotationMatrix();
  MatrixXd turn = MatrixXd::Zero(12, 12);
  for (Index i = 0; i < 12; i += 3) turn.block<3, 3>(i, i) = quarter;
  const auto joined = [&](const MatrixXd& beam) {
    MatrixXd all = MatrixXd::Zero(18, 18);
    all.topLeftCorner(12, 12) += beam;
    const MatrixXd second = turn * beam * turn.transpose();
    const auto at = [](Index i) { return i < 6 ? i : i + 6; };
    for (Index i = 0; i < 12; ++i) {
      for (Index j = 0; j < 12; ++j) all(at(i), at(j)) += second(i, j);
    }
    return all;
  };
  write(joined(book.M), joined(book.K));
  folder_.write("body.yaml",
                "interfaces: {a: [0, 0, 0], b: [1, 0, 0], c: [0, 1, 0]}\n"
                "mass_matrix: M.mtx\nstiffness_matrix: K.mtx\n");
  std::mt19937 engine(19);
  const auto text = [](const Vector3d& v) {
    return "{position: [" + shortest_digits(v.x()) + ", " + shortest_digits(v.y()) + ", " +
           shortest_digits(v.z()) + "]}";
  };
  VectorXd first;
  for (int trial = 0; trial < 5; ++trial) {
    Matrix3d R = Matrix3d::Identity();
    Vector3d t = Vector3d::Zero();
    if (trial > 0) {
      const Vector4 l = random_vector(4, engine).normalized();
      R = Eigen::Quaterniond(l(0), l(1), l(2), l(3)).toRotationMatrix();
      t = random_vector(3, engine);
    }
    const Vector3d foot = t + R * Vector3d(0.2, 0.3, -0.5);
    const Scene scene = parse_scene(
        "title: corner\nnodes: {a: " + text(t) + ", b: " + text(t + R.col(0)) +
            ", c: " + text(t + R.col(1)) + ", foot: " + text(foot) +
            "}\nmasses: []\nelements:\n  leg: {type: truss, nodes: [foot, b], stiffness: 100}\n"
            "  body: {nodes: [a, b, c], " +
            superelement() + "}\nsupports: [{nodes: [foot], fix: [x, y, z]}]\ndofs: auto\n",
        "corner.yaml");
    const VectorXd found = frequencies(scene);
    if (trial == 0) {
      first = found;
      continue;
    }
    for (Index i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found(i) * found(i), first(i) * first(i), 1e-12 * first.squaredNorm());
    }
  }
  // A mirror image is another body.
  EXPECT_THROW(parse_scene("title: corner\nnodes: {a: " + text({0, 0, 0}) +
                               ", b: " + text({1, 0, 0}) + ", c: " + text({0, 2, 0}) +
                               "}\nmasses: []\nelements:\n  body: {nodes: [a, b, c], " +
                               superelement() + "}\ndofs: auto\n",
                           "corner.yaml"),
               InputError);
}

TEST_F(BodyFiles, WhatIsNoBodyIsRefused) {
  const BookBeam book;
  write(book.M, book.K);
  ASSERT_EQ(refusal(), "");
  const auto refused = [&](const MatrixXd& M, const MatrixXd& K, const std::string& why) {
    write(M, K);
    EXPECT_NE(refusal().find(why), std::string::npos) << why << "\n" << refusal();
  };
  MatrixXd M = book.M, K = book.K;
  K(1, 1) += 1;
  refused(M, K, "resists a rigid translation along y");
  K = book.K;
  K.row(9).setZero();
  K.col(9).setZero();
  K.row(3).setZero();
  K.col(3).setZero();
  refused(M, K, "without stiffness");
  K = -book.K;
  refused(M, K, "negative");
  K = book.K;
  M(0, 0) *= 1.01;
  refused(M, K, "not the same in all directions");
  refused(-book.M, K, "indefinite");
  refused(MatrixXd::Zero(12, 12), K, "has no mass");
  // In other units than the positions.
  MatrixXd millimetres = book.K;
  for (Index i = 0; i < 12; ++i) {
    for (Index j = 0; j < 12; ++j) {
      const double turns = (i % 6 >= 3) + (j % 6 >= 3);
      millimetres(i, j) *= std::pow(1000.0, turns - 2);
    }
  }
  refused(book.M, millimetres, "other units");
  write(book.M, book.K);
  for (const auto& [key, why] :
       {std::pair("mass: 2.1\n", "the mass matrix has 2 kg"),
        std::pair("centre_of_mass: [0.4, 0, 0]\n", "centre of mass at [0.5, 0, 0] m"),
        std::pair("inertia: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\n", "about its centre of mass"),
        std::pair("modes: 1\n", "12 x 12, but 6 an interface and 1 a mode are 13")}) {
    folder_.write("body.yaml", body_of("M.mtx", "K.mtx") + key);
    EXPECT_NE(refusal().find(why), std::string::npos) << refusal();
  }
  folder_.write("body.yaml", body_of("M.mtx", "K.mtx") +
                                 "mass: 2\ncentre_of_mass: [0.5, 0, 0]\ninertia: [[0.01, 0, 0], "
                                 "[0, 0.16667, 0], [0, 0, 0.16667]]\n");
  EXPECT_EQ(refusal(), "");
}

TEST_F(BodyFiles, MatrixMarketIsReadAsItIsWrittenAndRefusedByLine) {
  std::mt19937 engine(23);
  const MatrixXd root = random_vector(25, engine).reshaped(5, 5), A = root + root.transpose();
  EXPECT_EQ(MatrixXd(parse_matrix_market(matrix_market(A, "any"), "A")), A);
  const std::string head = "%%MatrixMarket matrix coordinate real ";
  const MatrixXd sparse{{1, 2}, {2, 0}};
  EXPECT_EQ(MatrixXd(parse_matrix_market(head + "symmetric\n% c\n2 2 2\n1 1 1\n2 1 2e0\n", "A")),
            sparse);
  EXPECT_EQ(MatrixXd(parse_matrix_market(
                "%%matrixmarket MATRIX array integer general\n\n2 2\n1\n2\n2\n0\n", "A")),
            sparse);
  for (const auto& [text, where] :
       {std::pair(std::string("1 2 3\n"), "A:1: found '1 2 3'"),
        std::pair(head + "skew-symmetric\n2 2 1\n2 1 1\n", "A:1: "),
        std::pair(head + "general\n2 2\n", "A:2: found '2 2', allowed are three counts"),
        std::pair(head + "general\n2 2 2\n1 1 1\n", "A:3: the file ends, but 2 entries"),
        std::pair(head + "general\n2 2 1\n3 1 1\n", "A:3: found '3 1 1'"),
        std::pair(head + "general\n2 2 1\n1 1 nan\n", "A:3: found '1 1 nan'"),
        std::pair(head + "general\n2 2 1\n1 1 1\n1 2 1\n",
                  "A:4: found '1 2 1', allowed is nothing"),
        std::pair(head + "symmetric\n2 2 1\n1 2 1\n", "lower triangle"),
        std::pair(head + "symmetric\n2 3 1\n1 1 1\n", "square"),
        std::pair(std::string(), "A:0: the file ends")}) {
    try {
      parse_matrix_market(text, "A");
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(where), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace stillframe::test
