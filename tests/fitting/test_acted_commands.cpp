#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <random>

#include "controller/excitation.hpp"
#include "core/control/fitting/acted_commands.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::fitting {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// An amplifier that nobody chose.
struct Amplifier {
  double delay = 0;  ///< samples
  double lag = 0;    ///< samples, of the first order
  Index age = 0;     ///< samples, of what it reports
  double gain = 1, offset = 0, noise = 0, step = 0;
};

/// What it reports of commands that acted, by the exact step of its lag.
VectorXd reported(const Amplifier& amplifier, const VectorXd& acted, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto whole = static_cast<Index>(amplifier.delay);
  const double part = amplifier.delay - static_cast<double>(whole);
  const auto at = [&](Index k) { return k < 0 ? 0.0 : acted(k); };
  const auto follow = [&](double y, double to, double samples) {
    return amplifier.lag > 0 ? to + (y - to) * std::exp(-samples / amplifier.lag) : to;
  };
  VectorXd now(acted.size()), out(acted.size());
  double y = 0;
  for (Index k = 0; k < acted.size(); ++k) {
    now(k) = y;
    if (part > 0) y = follow(y, at(k - whole - 1), part);
    y = follow(y, at(k - whole), 1 - part);
  }
  for (Index k = 0; k < acted.size(); ++k) {
    const double value = amplifier.gain * now(std::max<Index>(0, k - amplifier.age)) +
                         amplifier.offset + amplifier.noise * normal(random);
    out(k) = amplifier.step > 0 ? amplifier.step * std::round(value / amplifier.step) : value;
  }
  return out;
}

/// Amplifiers, rates of late commands and lost samples that nobody chose: what acted is known at
/// every sample at which its command differed by more than a few steps of the report. Of none that
/// came in time is anything moved.
TEST(ActedCommands, AreReadOffTheReports) {
  constexpr Index n_window = 1000, n = 12 * n_window;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> part(0, 1);
  Index n_late = 0, n_wrong = 0, n_small = 0;
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE(trial);
    const double rate = trial % 4 == 0 ? 0 : std::pow(10, -4 + 2.7 * part(random));
    const std::vector<int> lines =
        controller::logarithmic_lines(2, 420, 44, [](int line) { return line % 7 == 0; });
    const VectorXd wave = 10 * controller::multisine(lines, n_window);
    MatrixXd sent = MatrixXd::Zero(n, 3), acted = sent, applied = sent;
    std::vector<bool> missing(n, false);
    // Legs one after the other, as a rig is recorded; in every third trial all at once, as in a
    // loop.
    for (Index k = n_window; k < n - n_window; ++k) {
      for (Index leg = 0; leg < 3; ++leg) {
        const bool driven = trial % 3 == 0 || k / (4 * n_window) == leg;
        sent(k, leg) = driven ? wave((k + 300 * leg) % n_window) : 0;
      }
    }
    for (Index k = 0; k < n; ++k) {
      missing[static_cast<std::size_t>(k)] = part(random) < 1e-3;
      const bool late = k > 20 && k + 60 < n && part(random) < rate;
      acted.row(k) = late ? acted.row(k - 1) : sent.row(k);
      n_late += late && acted.row(k) != sent.row(k);
    }
    double least = 0;  // N, a change that reports tell for certain
    for (Index leg = 0; leg < 3; ++leg) {
      const Amplifier amplifier{.delay = (trial % 5 == 0 ? 20 : 3) * part(random),
                                .lag = trial % 2 == 0 ? 0 : 2 * part(random),
                                .age = static_cast<Index>(3 * part(random)),
                                .gain = 0.9 + 0.2 * part(random),
                                .offset = part(random),
                                .noise = 0.01 * part(random),
                                .step = 0.01};
      applied.col(leg) = reported(amplifier, acted.col(leg), random);
      // Its step and noise, sixteen times, by the part of a change that one sample tells of.
      const double tells = amplifier.lag > 0 ? 1 - std::exp(-0.5 / amplifier.lag) : 0.5;
      least = std::max(least, 16 * (amplifier.noise + 0.004) / tells);
    }
    const ActedCommands found = acted_commands(sent, applied, missing);
    if (rate == 0) EXPECT_EQ(found.n_late, 0);
    for (Index k = 0; k < n; ++k) {
      const double off = (found.command.row(k) - acted.row(k)).cwiseAbs().maxCoeff();
      // Where its report did not come nothing tells.
      const auto told = missing.begin() + k;
      const Index reach = trial % 5 == 0 ? 32 : 8;
      if (off == 0 || std::find(told, told + reach, true) != told + reach) continue;
      (off > least ? n_wrong : n_small) += 1;
    }
  }
  std::cout << n_late << " late: " << n_wrong << " wrong, " << n_small
            << " wrong by less than reports tell\n";
  EXPECT_GT(n_late, 1000);
  EXPECT_EQ(n_wrong, 0);
}

/// What 16 weights cannot say is no late command: amplifiers of a slow lag, that ring, clip or
/// stick, with reports in steps and long rests, none late. A fit that was right stays so.
TEST(ActedCommands, AnAmplifierThatIsNotSaidHasNoLateOnes) {
  constexpr Index n_window = 1000, n = 20 * n_window;
  const VectorXd wave =
      10 * controller::multisine(controller::logarithmic_lines(2, 420, 44), n_window);
  MatrixXd sent = MatrixXd::Zero(n, 2);
  for (Index k = 8 * n_window; k < 18 * n_window; ++k) {
    sent(k, k < 13 * n_window ? 0 : 1) = wave(k % n_window);
  }
  std::mt19937_64 random(3);
  using Report = std::function<VectorXd(const VectorXd&)>;
  const auto lagging = [&](double samples) -> Report {
    return [&random, samples](const VectorXd& u) {
      return reported({.delay = 1.3, .lag = samples, .noise = 1e-3, .step = 5e-3}, u, random);
    };
  };
  const Report ringing = [](const VectorXd& u) {
    VectorXd y = VectorXd::Zero(u.size());
    for (Index k = 2; k < u.size(); ++k) {
      const double w = 2 * std::sin(two_pi * 0.05), c = 0.02 * w;
      y(k) = (2 - w * w - c) * y(k - 1) - (1 - c) * y(k - 2) + w * w * u(k - 1);
    }
    return y;
  };
  const Report clipping = [](const VectorXd& u) { return u.cwiseMax(-5).cwiseMin(5).eval(); };
  const Report sticking = [](const VectorXd& u) {
    VectorXd y = u;
    for (Index k = 1; k < u.size(); ++k) y(k) = std::clamp(y(k - 1), u(k) - 0.5, u(k) + 0.5);
    return y;
  };
  for (const Report& report : {lagging(0), lagging(2), lagging(5), lagging(20), lagging(100),
                               Report(ringing), Report(clipping), Report(sticking)}) {
    MatrixXd applied(n, 2);
    for (Index leg = 0; leg < 2; ++leg) applied.col(leg) = report(sent.col(leg));
    EXPECT_EQ(acted_commands(sent, applied, {}).n_late, 0);
  }
}

/// What amplifiers do not report is left as it was sent.
TEST(ActedCommands, NothingIsMovedWithoutReports) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const MatrixXd sent = MatrixXd::NullaryExpr(2000, 2, [&] { return normal(random); });
  for (const double noise : {0.0, 1.0}) {
    const MatrixXd applied = MatrixXd::NullaryExpr(2000, 2, [&] { return noise * normal(random); });
    const ActedCommands found = acted_commands(sent, applied, {});
    EXPECT_EQ(found.n_late, 0);
    EXPECT_EQ(found.command, sent);
  }
  EXPECT_EQ(acted_commands(sent.topRows(3), sent.topRows(3), {}).command, sent.topRows(3));
}

}  // namespace
}  // namespace stillframe::fitting
