#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/certificate.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/scenes.hpp"

// What cannot be computed is not certified, not sorted and not looked up.
namespace stillframe::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Worst, KeepsWhatIsNotANumber) {
  EXPECT_EQ(worst_of(1, 2), 2);
  EXPECT_TRUE(std::isnan(worst_of(nan, 1)));
  EXPECT_TRUE(std::isnan(worst_of(1, nan)));  // std::max answers 1
  EXPECT_TRUE(std::isnan(worst_of({1, nan, 3})));
  // Wherever it stands, also where vectors of registers hide it from maxCoeff().
  for (Eigen::Index n = 1; n <= 40; ++n) {
    const Eigen::VectorXcd values = Eigen::VectorXcd::LinSpaced(n, {1, 2}, {3, -4});
    EXPECT_EQ(worst_of(values), 5) << n;
    EXPECT_EQ(worst_of(values.real()), 3) << n;
    for (Eigen::Index i = 0; i < n; ++i) {
      Eigen::VectorXcd broken = values;
      broken(i).imag(nan);
      EXPECT_TRUE(std::isnan(worst_of(broken))) << i << " of " << n;
      EXPECT_TRUE(std::isnan(worst_of(broken.imag()))) << i << " of " << n;
    }
  }
  EXPECT_EQ(worst_of(Eigen::MatrixXd(0, 3)), 0);
}

TEST(Certificates, OfWhatIsNotANumberIsNone) {
  // A stiffness whose square overflows: differences of infinite forces.
  Scene scene = strung_mass(1);
  for (SceneElement& element : scene.elements) element.stiffness(0, 0) = 1e308;
  for (const BlockCertificate& block : certify(scene)) {
    if (block.block == "K") {
      EXPECT_FALSE(block.difference <= certified_difference) << block.difference;
    }
  }
}

TEST(Modes, WithoutFiniteEigenvaluesAreRefused) {
  LinearModel linear = linearise(make_model(strung_mass(1)), {}, {});
  linear.D(0, 0) = 1;  // not undamped, so that the state matrix is needed
  EXPECT_NO_THROW(modes(linear));
  for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
    LinearModel broken = linear;
    broken.D(1, 0) = bad;
    EXPECT_THROW(modes(broken), Refusal) << bad;
  }
}

/// What a call says that looks a name up.
template <class Call>
std::string said(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "found";
}

TEST(Names, ThatAreNotThereAreAnsweredWithTheNearest) {
  const Model model = make_model(frame_scene());
  EXPECT_EQ(said([&] { model.node_index("mount_1"); }), "found");
  EXPECT_EQ(said([&] { model.node_index("muont_1"); }),
            "there is no node 'muont_1'; the nearest name is 'mount_1'");
  EXPECT_EQ(said([&] { model.element_index("arm1"); }),
            "there is no element 'arm1'; the nearest name is 'arm_1'");
  EXPECT_EQ(said([&] { model.deformation_row("arm_1", 7); }),
            "deformation 7 of 'arm_1': allowed are 1 to 6");
  EXPECT_EQ(said([&] { model.deformation_row("arm_1", 0); }),
            "deformation 0 of 'arm_1': allowed are 1 to 6");
  EXPECT_NE(said([&] { model.owner_of_row(model.n_e); }), "found");
}

}  // namespace
}  // namespace stillframe::test
