#include <gtest/gtest.h>

#include <Eigen/LU>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>

#include "core/control/close_loop.hpp"
#include "core/control/disk_margin.hpp"
#include "core/control/open_plant.hpp"
#include "core/control/own_law.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/core/random_loops.hpp"

// A law by names is held against the loop that it closes: by a fraction of the open plant and the
// law, which knows nothing of the order of states in close_loop, and by our own laws written as
// one.
namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

constexpr int n_loops = 40;
constexpr Index p = 2, n_y = 3;

std::vector<std::string> names_of(const char* prefix, Index n) {
  std::vector<std::string> names;
  for (Index i = 0; i < n; ++i) names.push_back(prefix + std::to_string(i + 1));
  return names;
}

/// A random loop with a floor that pushes on its modes, outputs, and a feed-forward in its law.
struct Case {
  SampledPlant plant;
  LoopSettings settings;
  DiscreteLaw law;
  std::vector<std::string> legs, floor;

  explicit Case(unsigned seed) : settings(random_loop(seed)) {
    Draws draw(1000 + seed);
    const auto random = [&](Index rows, Index cols) {
      return MatrixXd(MatrixXd::NullaryExpr(rows, cols, [&] { return draw.between(-1, 1); }));
    };
    LoopPlant& has = settings.plant;
    const Index n = has.A.rows(), m = has.B_u.cols();
    has.B_w = MatrixXd::Zero(n, p);
    has.B_w.bottomRows(n / 2) = random(n / 2, p);
    const MatrixXd of_accelerations = random(n_y, n / 2);
    has.C_y = of_accelerations * has.A.bottomRows(n / 2);
    has.D_yw = of_accelerations * has.B_w.bottomRows(n / 2);
    has.D_yu = of_accelerations * has.B_u.bottomRows(n / 2);
    plant = sample_and_hold(has, settings.sampling);
    law = law_of(settings);
    if (draw.coin()) {
      law.feed_forward =
          feed_forward_system({.memory = 0.98, .n_taps = 3, .weights = random(m, p * 5)});
    }
    legs = names_of("leg_", m);
    floor = names_of("floor_", p);
  }
};

MatrixXcd response(const LinearSystem& system, Complex z) {
  MatrixXcd resolvent = -system.A.cast<Complex>();
  resolvent.diagonal().array() += z;
  return system.C.cast<Complex>() * resolvent.partialPivLu().solve(system.B.cast<Complex>()) +
         system.D.cast<Complex>();
}

/// Rows of the measurement that a law hears, by name, of y, sigma, applied and floor.
MatrixXd heard_of(const NamedLaw& law, const Case& c) {
  const Index m = std::ssize(c.legs);
  const std::vector<std::string>& names = law.inputs;
  MatrixXd rows = MatrixXd::Zero(std::ssize(names), 2 * m + p);
  for (Index i = 0; i < rows.rows(); ++i) {
    const std::string& name = names[static_cast<size_t>(i)];
    const Index number = name.back() - '1';
    if (name.starts_with("sigma:") || name.starts_with("strain_force:")) rows(i, number) = 1;
    if (name.starts_with("applied:")) rows(i, m + number) = 1;
    if (name.starts_with("strain_force:")) rows(i, m + number) = -1;
    if (name.starts_with("floor:")) rows(i, 2 * m + number) = 1;
  }
  return rows;
}

/// T of the open plant and the law around it.
MatrixXcd by_fractions(const Case& c, const NamedLaw& law, Complex z) {
  const Index m = std::ssize(c.legs);
  const MatrixXcd G = response(open_plant(c.plant), z);
  const MatrixXcd heard = heard_of(law, c).cast<Complex>() * G.bottomRows(2 * m + p);
  MatrixXcd F = response({law.A, law.B, law.C, law.D}, z), ordered = F;
  for (Index i = 0; i < m; ++i) {
    ordered.row(law.outputs[static_cast<size_t>(i)].back() - '1') = F.row(i);
  }
  const MatrixXcd I = MatrixXcd::Identity(m, m);
  return G.topLeftCorner(n_y, p) +
         G.topRightCorner(n_y, m) *
             (I - ordered * heard.rightCols(m)).partialPivLu().solve(ordered * heard.leftCols(p));
}

void expect_same_loop(const Case& c, const DiscreteLaw& law, const NamedLaw& as_named) {
  const SampledLoop loop = close_loop(c.plant, law);
  Draws draw(7);
  for (int i = 0; i < 6; ++i) {
    // Off the circle, where no undamped mode makes rounding large.
    const double angle = draw.between(0.01, std::numbers::pi);
    const Complex z = std::polar(1.05, angle);
    const MatrixXcd should = by_fractions(c, as_named, z),
                    is = response({loop.A, loop.B, loop.C, loop.D}, z);
    // Modes, gains and rates of random loops lie up to six decades apart.
    EXPECT_LT((is - should).norm(), 1e-8 * should.norm()) << angle;
  }
}

TEST(OpenPlant, ClosedByOurLawIsTheLoop) {
  for (unsigned seed = 0; seed < n_loops; ++seed) {
    SCOPED_TRACE(seed);
    const Case c(seed);
    expect_same_loop(c, c.law, named(c.law, c.legs, c.floor));
  }
}

TEST(OwnLaw, OursWrittenByNamesIsTheSameLoop) {
  for (unsigned seed = 0; seed < n_loops; ++seed) {
    SCOPED_TRACE(seed);
    const Case c(seed);
    const NamedLaw by_names = named(c.law, c.legs, c.floor);
    const DiscreteLaw own = own_law(by_names, c.legs, c.floor);
    expect_same_loop(c, own, by_names);
    const SampledLoop ours = close_loop(c.plant, c.law), theirs = close_loop(c.plant, own);
    const double radius = spectral_radius(ours);
    // Poles of one place are known to the root of rounding only.
    EXPECT_NEAR(spectral_radius(theirs), radius, 1e-6 * radius);
    for (const double part : {0.01, 0.1, 0.4}) {
      const double omega = two_pi * part / c.plant.sample_time;
      const MatrixXcd L = return_ratio(c.plant, c.law, omega);
      EXPECT_LT((return_ratio(c.plant, own, omega) - L).norm(), 1e-7 * L.norm()) << part;
      const MatrixXcd N = noise_transfer(ours, omega);
      EXPECT_LT((noise_transfer(theirs, omega) - N).norm(), 1e-7 * N.norm()) << part;
    }
  }
}

/// A law of any states, inputs and outputs in any order.
NamedLaw random_law(const Case& c, unsigned seed) {
  Draws draw(seed);
  const Index n = static_cast<Index>(draw.between(0, 6)), m = std::ssize(c.legs);
  NamedLaw law;
  for (Index i = m; i-- > 0;) {
    const std::string& leg = c.legs[static_cast<size_t>(i)];
    law.outputs.push_back("force:" + leg);
    if (draw.coin()) law.inputs.push_back("applied:" + leg);
    law.inputs.push_back((draw.coin() ? "sigma:" : "strain_force:") + leg);
  }
  law.inputs.insert(law.inputs.begin() + 1, "floor:" + c.floor[1]);
  if (draw.coin()) law.inputs.push_back("floor:" + c.floor[0]);
  const auto random = [&](Index rows, Index cols) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, cols, [&] { return draw.between(-1, 1); }));
  };
  law.A = random(n, n);
  if (n > 0) law.A *= 0.9 / std::max(0.1, spectral_radius(law.A));
  law.B = random(n, std::ssize(law.inputs));
  law.C = random(m, n);
  law.D = random(m, std::ssize(law.inputs));
  return law;
}

TEST(OwnLaw, OfAnyOrderClosesTheLoopOfItsNames) {
  for (unsigned seed = 0; seed < n_loops; ++seed) {
    SCOPED_TRACE(seed);
    const Case c(seed);
    const NamedLaw law = random_law(c, seed);
    expect_same_loop(c, own_law(law, c.legs, c.floor), law);
  }
}

TEST(OwnLaw, DiskMarginsAreThoseOfItsReturnRatio) {
  for (unsigned seed = 0; seed < n_loops; ++seed) {
    SCOPED_TRACE(seed);
    Case c(seed);
    c.settings.own = own_law(random_law(c, seed), c.legs, c.floor);
    const SampledPlant plant =
        sample_and_hold(feedback_part(c.settings.plant), c.settings.sampling);
    const LinearSystem half = half_sensitivity(c.settings);
    for (const double part : {0.013, 0.12, 0.43}) {
      const double omega = two_pi * part / c.plant.sample_time;
      const MatrixXcd L = return_ratio(plant, law_of(c.settings), omega);
      const MatrixXcd I = MatrixXcd::Identity(L.rows(), L.rows());
      const MatrixXcd should = (I + L).inverse() - 0.5 * I,
                      is = response(half, std::polar(1.0, two_pi * part));
      EXPECT_LT((is - should).norm(), 1e-7 * should.norm()) << part;
    }
  }
}

TEST(OwnLaw, IsDeafWithoutItsFloor) {
  const Case c(3);
  const NamedLaw law = random_law(c, 3);
  ASSERT_TRUE(hears_floor(law));
  const NamedLaw deaf = without_floor(law);
  EXPECT_FALSE(hears_floor(deaf));
  const DiscreteLaw with = own_law(law, c.legs, c.floor), without = own_law(deaf, c.legs, c.floor);
  EXPECT_EQ(without.feed_forward.D.size(), 0);
  EXPECT_EQ(with.D, without.D);
  EXPECT_EQ(with.A, without.A);
}

std::string refusal(const NamedLaw& law, const Case& c) {
  try {
    own_law(law, c.legs, c.floor);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(OwnLaw, SaysWhatIsWrongWithIt) {
  const Case c(3);
  NamedLaw good = random_law(c, 3);
  while (good.A.rows() < 2) good = random_law(c, static_cast<unsigned>(good.A.rows()) + 90);
  ASSERT_EQ(refusal(good, c), "");
  const auto refused = [&](const std::function<void(NamedLaw&)>& change) {
    NamedLaw law = good;
    change(law);
    return refusal(law, c);
  };
  const auto expect = [&](const std::string& what, const std::function<void(NamedLaw&)>& change) {
    const std::string said = refused(change);
    EXPECT_NE(said.find(what), std::string::npos) << said;
  };
  expect("inputs: found \"sigma:leg_9\", which no measurement holds",
         [](NamedLaw& law) { law.inputs[0] = "sigma:leg_9"; });
  expect("hears no acceleration of the frame",
         [](NamedLaw& law) { law.inputs[0] = "frame:floor_1"; });
  expect("\" twice", [](NamedLaw& law) { law.inputs[0] = law.inputs[1]; });
  expect("outputs: found \"u\", allowed is one for each leg: force:leg_1",
         [](NamedLaw& law) { law.outputs[0] = "u"; });
  expect("D: found a number that is not finite",
         [](NamedLaw& law) { law.D(0, 0) = std::numeric_limits<double>::quiet_NaN(); });
  expect("B: found", [](NamedLaw& law) { law.B.conservativeResize(law.A.rows() + 1, 1); });
  expect("what a law does with the floor has to decay by itself",
         [](NamedLaw& law) { law.A *= 1.2; });
}

}  // namespace
}  // namespace stillframe::test
