#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <complex>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "controller/excitation.hpp"
#include "core/control/close_loop.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/broken_channels/episodes.hpp"
#include "tests/controller/rig.hpp"

namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = ExcitationPlan::Kind;

Policy exciting(Kind kind, double force_n, double window_s = 1, std::int64_t windows = 2) {
  Policy policy;
  policy.excitation = {.kind = kind, .force_n = force_n, .window_s = window_s, .windows = windows};
  return policy;
}

/// The floor at rest but for what arming asks for.
void nearly_still(Rig& rig) {
  rig.floor = [](std::int64_t k, VectorXd& w) { w.setConstant(k % 2 == 0 ? 1e-9 : -1e-9); };
}

TEST(Excitation, LinesAreWholeAndRise) {
  const auto lines = logarithmic_lines(2, 420, 44);
  ASSERT_GE(lines.size(), 40u);
  EXPECT_EQ(lines.front(), 2);
  EXPECT_EQ(lines.back(), 420);
  EXPECT_TRUE(std::ranges::is_sorted(lines, std::less_equal<int>()));
  EXPECT_TRUE(logarithmic_lines(5.5, 5.6, 10).empty());
  EXPECT_EQ(logarithmic_lines(3, 3.2, 10), std::vector<int>{3});
}

/// Each leg alone, its whole wave in its own windows, nothing before and behind; multisine and step
/// reach the force that was asked for, and a multisine has its lines and no other.
TEST(Excitation, DrivesOneLegAfterTheOther) {
  const Gains gains = toy::damped_gains();
  const Index m = gains.n_legs();
  for (const Kind kind : {Kind::multisine, Kind::sweep, Kind::step}) {
    Excitation excitation(gains, exciting(kind, 5));
    const Index n = excitation.n_window();
    ASSERT_EQ(n, 1000);
    EXPECT_EQ(excitation.at(7).norm(), 0);  // it has not begun
    excitation.begin(100);
    excitation.begin(200);
    ASSERT_EQ(excitation.n_samples(), n * (2 + 4 * m));
    MatrixXd all(excitation.n_samples() + 200, m);
    for (Index k = 0; k < all.rows(); ++k) all.row(k) = excitation.at(k).transpose();
    EXPECT_EQ(all.topRows(100 + 2 * n).norm(), 0);
    EXPECT_EQ(all.bottomRows(100).norm(), 0);
    for (Index leg = 0; leg < m; ++leg) {
      const Index from = 100 + (2 + 4 * leg) * n;
      const MatrixXd part = all.middleRows(from, 4 * n);
      const double own = part.col(leg).squaredNorm();
      EXPECT_GT(own, 0);
      EXPECT_EQ(part.squaredNorm(), own);
      const VectorXd first = part.col(leg).segment(n, n), second = part.col(leg).segment(2 * n, n);
      EXPECT_EQ((first - second).norm(), 0);
      const double peak = first.lpNorm<Eigen::Infinity>();
      EXPECT_LE(peak, 5 * (1 + 1e-12));
      EXPECT_GT(peak, kind == Kind::sweep ? 4.9 : 5 * (1 - 1e-12));
      if (kind != Kind::multisine) continue;
      std::map<int, double> power;
      for (int line = 1; line < n / 2; ++line) {
        std::complex<double> sum = 0;
        for (Index k = 0; k < n; ++k) {
          sum += first(k) *
                 std::polar(1.0, -two_pi * line * static_cast<double>(k) / static_cast<double>(n));
        }
        if (std::abs(sum) > 1e-9 * n) power[line] = std::norm(sum);
      }
      EXPECT_EQ(power.size(), excitation.lines().size());
      for (const int line : excitation.lines()) EXPECT_TRUE(power.contains(line)) << line;
    }
  }
}

/// What a loop makes of it, sample by sample through supervisor and law, is what the transfer
/// function of the closed loop says; with the law left out what that of the plant says.
TEST(Excitation, IsAnsweredAsTheLoopIsPredicted) {
  const Gains gains = toy::damped_gains();
  const Index m = gains.n_legs();
  for (const bool open : {false, true}) {
    SCOPED_TRACE(open);
    // A law that makes a 49 Hz leg one of 5 Hz answers slow forces by a hundred times as much.
    Policy policy = exciting(Kind::multisine, 0.5, 2, 8);
    policy.excitation.open_loop = open;
    policy.require_motion = false;
    Rig rig(policy, true, gains);
    nearly_still(rig);
    ASSERT_TRUE(rig.reaches(State::active, 5000));
    while (rig.supervisor().excitation().start() < 0) rig.step();
    Excitation plan = rig.supervisor().excitation();
    const Index n = plan.n_window();
    // Of the last window of each leg, when what rang at its beginning is nearly gone.
    SampledPlant plant = sample_and_hold(gains.loop_plant(), gains.sampling());
    plant.C_y = plant.C_sigma;
    plant.D_0 = plant.D_sigma;
    plant.D_yu = MatrixXd::Zero(m, m);
    plant.D_yw = MatrixXd::Zero(m, plant.Gamma_w.cols());
    DiscreteLaw law = law_from_gains(gains);
    if (open) {
      law.C.setZero();
      law.D.setZero();
    }
    const SampledLoop loop = close_loop_with_added_force(plant, law);
    const std::int64_t last = plan.start() + plan.n_samples();
    MatrixXd sigma(plan.n_samples() + 1, m), added(plan.n_samples() + 1, m);
    for (std::int64_t k = rig.k(); k < last; ++k) {
      added.row(k - plan.start()) = plan.at(k).transpose();
      rig.step();
      sigma.row(k - plan.start()) = rig.sigma.transpose();
      ASSERT_EQ(rig.state(), State::active) << to_text(rig.fault());
    }
    // Not even where nothing but the excitation moves anything.
    EXPECT_EQ(rig.loop().counters().n_saturated, 0);
    for (Index leg = 0; leg < m; ++leg) {
      const Index from = static_cast<Index>(8 * n + leg * 10 * n + 8 * n);
      for (const int line : plan.lines()) {
        Eigen::VectorXcd Y = Eigen::VectorXcd::Zero(m);
        std::complex<double> E = 0;
        for (Index k = 0; k < n; ++k) {
          const auto turn = std::polar(
              1.0, -two_pi * static_cast<double>((line * k) % n) / static_cast<double>(n));
          Y += sigma.row(from + k).transpose() * turn;
          E += added(from + k, leg) * turn;
        }
        const double omega = two_pi * line * gains.sample_rate_hz / static_cast<double>(n);
        // y of the plant above is sigma a sample late.
        const MatrixXcd T =
            transfer(loop, omega).rightCols(m) * std::polar(1.0, omega * gains.sample_time());
        // Without the law the slowest mode, damped by 1 %, has rung for 16 s and is down to 1e-6;
        // the law's leak of 0.05 Hz leaves e^-5 of what began with a leg, which is slow and small.
        EXPECT_LT((Y / E - T.col(leg)).norm(), 1e-4 * T.norm()) << line << " leg " << leg;
      }
    }
  }
}

/// Loops on frames that differ from their model, driven hard from rest and on a floor: no fault,
/// and no command that the last gate had to hold back.
TEST(Excitation, IsNoFaultOfASoundLoop) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> off(-1, 1);
  const Kind kinds[] = {Kind::multisine, Kind::sweep, Kind::step};
  for (int trial = 0; trial < 24; ++trial) {
    const bool shipped = trial % 4 == 0;
    const Gains gains = shipped ? shipped_gains("force_feedback_5hz")
                                : toy::damped_gains(5, trial % 3 == 0 ? 2000 : 1000);
    Gains frame = gains;
    const Index m = gains.n_legs();
    for (Index i = 0; i < m && !shipped; ++i) {
      const double factor = 1 + 0.15 * off(random);
      frame.plant.A.row(m + i).head(m) *= factor;
      frame.plant.C.row(i) *= factor;
    }
    // What the law makes of it is up to a hundred times as much, and more of a step, of which it
    // makes a velocity.
    const double part = kinds[trial % 3] == Kind::step ? 1e-4 : 1e-3;
    const double force = *gains.force_limit_n * (trial % 2 == 0 ? part / 10 : part);
    Policy policy = exciting(kinds[trial % 3], force, 0.5);
    policy.require_motion = false;
    Rig rig(policy, true, gains, frame);
    const double loud = trial % 5 == 0 ? 1e-6 : trial % 5 == 1 ? 0.005 : 1e-3;
    std::normal_distribution<double> normal;
    VectorXd slow = VectorXd::Zero(gains.plant.B_w.cols());
    rig.floor = [&](std::int64_t, VectorXd& w) {
      slow += 0.05 * (VectorXd::Constant(slow.size(), loud * normal(random)) - slow);
      w = slow;
    };
    SCOPED_TRACE("trial " + std::to_string(trial));
    ASSERT_TRUE(rig.reaches(State::active, 20'000)) << to_text(rig.state());
    const std::int64_t n = rig.supervisor().excitation().n_samples() + 500;
    for (std::int64_t k = 0; k < n; ++k) {
      // A sample in fifty does not come.
      rig.step(random() % 50 == 0 ? toy::nothing : Rig::Wire{});
      ASSERT_EQ(rig.state(), State::active) << k << " " << to_text(rig.fault());
    }
    EXPECT_EQ(rig.loop().counters().n_saturated, 0) << rig.largest_force;
    EXPECT_GT(rig.supervisor().excitation().start(), 0);
  }
}

/// A cable that breaks while it goes on is found as without, and the frame is let go of before it
/// swings further than twice what the excitation and the floor had made of it, or the frame alone.
TEST(Excitation, DoesNotHideABrokenCable) {
  const Gains gains = toy::damped_gains();
  for (int what = 0; what < 3; ++what) {
    SCOPED_TRACE(what);
    const double passive = toy::passive_peak(20'000);
    Policy policy = exciting(Kind::multisine, 4);
    Rig rig(policy, true, gains);
    ASSERT_TRUE(rig.reaches(State::active, 5000));
    rig.steps(3500);
    const double before = rig.peak;
    rig.peak = 0;
    const auto broken = [&](Measurement& m) {
      if (what == 0) m.sigma(1) *= -1;
      if (what == 1) m.applied(0) *= 1.5;
      if (what == 2) std::swap(m.sigma(0), m.sigma(3));
      return true;
    };
    for (int k = 0; k < 8000 && rig.state() == State::active; ++k) rig.step(broken);
    EXPECT_EQ(rig.state(), State::fault);
    EXPECT_TRUE(rig.latched());
    rig.steps(3000, broken);
    EXPECT_LT(rig.force().norm(), 1e-12);
    EXPECT_LT(rig.peak, 2 * std::max(before, passive));
  }
}

/// It goes with the gain when it is asked to stop, and by the numbers of the samples when it comes
/// back.
TEST(Excitation, EndsWithTheLoop) {
  Policy policy = exciting(Kind::step, 2);
  Rig rig(policy);
  ASSERT_TRUE(rig.reaches(State::active, 5000));
  rig.steps(3200);
  ASSERT_GT(rig.supervisor().excited().norm(), 1.9);
  rig.loop().request(Request::stop);
  rig.largest_jump = 0;
  ASSERT_TRUE(rig.reaches(State::idle, 3000));
  rig.steps(1500);
  EXPECT_EQ(rig.force().norm(), 0);
  EXPECT_EQ(rig.supervisor().excited().norm(), 0);
  const std::int64_t began = rig.supervisor().excitation().start();
  rig.loop().request(Request::start);
  ASSERT_TRUE(rig.reaches(State::active, 5000));
  rig.steps(10);
  EXPECT_EQ(rig.supervisor().excitation().start(), began);
  Excitation plan = rig.supervisor().excitation();
  EXPECT_EQ(rig.supervisor().excited(), plan.at(rig.k() - 1));
}

/// From a checkpoint in the middle of it, or while the loop is not there after a fault that passed,
/// every command and all that is remembered come again to the bit.
TEST(Excitation, IsInTheMemory) {
  const Gains gains = toy::damped_gains();
  // Nothing here answers a force, so it has to be small beside the noise.
  Policy policy = exciting(Kind::multisine, 1e-3, 0.5);
  policy.free_rate_n_per_s = 1e6;
  policy.limited_part = 1;
  Supervisor one(gains, policy, true), other(gains, policy, true);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Measurement now = measurement_of(gains.n_legs(), 0);
  Command command = command_of(gains.n_legs()), again = command;
  std::vector<double> memory(one.memory_size()), restored(memory);
  std::int64_t n_excited = 0;
  for (std::int64_t k = 0; k < 11'000; ++k) {
    now.seq = k;
    now.time_ns = k * 1'000'000;
    for (double& value : now.sigma) value = 0.9 * value + 0.01 * normal(random);
    now.applied = command.force;
    const bool silent = k > 5000 && k < 6300;
    if (k == 4000 || k == 6200) {
      one.save(memory);
      other = Supervisor(gains, policy, true);
      other.restore(memory);
    }
    const Event event{.measurement = silent || k % 97 == 0 ? nullptr : &now};
    one.step(event, command);
    if (k < 4000) continue;
    other.step(event, again);
    ASSERT_EQ(command.force, again.force) << k;
    ASSERT_EQ(one.excited(), other.excited()) << k;
    one.save(memory);
    other.save(restored);
    // What is not known may be no number.
    ASSERT_EQ(std::memcmp(memory.data(), restored.data(), 8 * memory.size()), 0) << k;
    n_excited += k > 6300 && !one.excited().isZero(0);
  }
  EXPECT_EQ(one.n_rejoins(), 1);
  EXPECT_GT(n_excited, 500);
}

TEST(Excitation, RefusesWhatDoesNotFit) {
  const Gains gains = toy::damped_gains();
  const auto error_of = [&](const ExcitationPlan& plan) -> std::string {
    Policy policy;
    policy.excitation = plan;
    try {
      Excitation excitation(gains, policy);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const Kind kind = Kind::multisine;
  EXPECT_EQ(error_of({.kind = kind}), "");
  EXPECT_EQ(error_of({.kind = kind, .force_n = 200}),
            "excitation.force_n: found 200, allowed is a number below the force limit, 200");
  EXPECT_NE(error_of({.kind = kind, .from_hz = 0.1}).find("excitation.from_hz"), std::string::npos);
  EXPECT_NE(error_of({.kind = kind, .to_hz = 495}).find("excitation.to_hz"), std::string::npos);
  EXPECT_NE(error_of({.kind = kind, .from_hz = 20, .to_hz = 10}).find("excitation.from_hz"),
            std::string::npos);
  // Between two lines there is none.
  EXPECT_NE(error_of({.kind = kind, .from_hz = 0.6, .to_hz = 0.9}).find("excitation.to_hz"),
            std::string::npos);
  EXPECT_NE(error_of({.kind = kind, .window_s = 0.001}).find("excitation.window_s"),
            std::string::npos);
  EXPECT_EQ(error_of({.kind = Kind::none, .force_n = 1e9}), "");
  const Policy read = parse_policy("ramp: {in_s: 1}\nexcitation: {kind: sweep, force_n: 300}\n",
                                   "policy.yaml", gains.sample_rate_hz);
  EXPECT_EQ(error_of(read.excitation),
            "policy.yaml:2:13: excitation.force_n: found 300, allowed is a number below the force "
            "limit, 200");
}

}  // namespace
}  // namespace stillframe::controller
