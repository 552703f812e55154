#include <gtest/gtest.h>

#include <cmath>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

/// Deformations and stresses under a motion of q_d: linear ones D_F^(e) q against those of the
/// nonlinear equations.
double nonlinearity(const Model& model, double size, double& moved) {
  Data data(model);
  geometric_transfer_functions(model, data);
  const RowMatrix DF = data.DF, DF_e = data.DF_e;
  MotionState state(model);
  for (Index i = 0; i < model.n_d; ++i)
    state.q_d(i) = size * std::cos(1.0 + static_cast<double>(i));
  EXPECT_TRUE(solve_positions(model, data, state));
  const Eigen::VectorXd linear = DF * state.q_d;
  moved = linear.lpNorm<Eigen::Infinity>();
  double worst = (data.x - linear).lpNorm<Eigen::Infinity>() / moved;
  if (model.n_redundant > 0) {
    const Eigen::VectorXd e = DF_e * state.q_d;
    worst = worst_of(worst, (data.e.tail(model.n_redundant) - e).lpNorm<Eigen::Infinity>() /
                                e.lpNorm<Eigen::Infinity>());
  }
  return worst;
}

// A motion of size s on a geometry of a metre is linear up to about s (relative), and rounding must
// stay a few epsilon of the motion, not of the metre: that would be 1e-16 / 1e-12 = 1e-4.
TEST(SmallMotion, PicometresKeepTheirDigitsOnMetres) {
  for (const char* name : {"metrology_frame", "cantilever", "slider_crank", "spinning_arm"}) {
    const Model model = make_model(
        read_scene(std::string(STILLFRAME_SOURCE_DIR "/config/scenes/") + name + ".yaml"));
    for (const double size : {1e-6, 1e-9, 1e-12}) {
      double moved = 0;
      const double error = nonlinearity(model, size, moved);
      char what[64];
      std::snprintf(what, sizeof what, "%s moves by %.0e m", name, moved);
      reached(what, error, 1 / moved);
      // 100: curvature of the motion over the smallest length of the scenes, 0.1 m, and their arms.
      EXPECT_LE(error, 100 * moved + 1e-13) << name;
    }
  }
}

}  // namespace
}  // namespace stillframe::test
