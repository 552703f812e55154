#include "controller/rig/wiring.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/errors/formatted.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;

constexpr double driven_from = 0.2;  // of the rate
constexpr int most_lines = 12;
constexpr double least_answer = 0.2;   // of what the plant says, of a cable that is there
constexpr double second_answer = 0.5;  // of the largest: two legs answer, which is no cable
constexpr double most_beyond = 1.5;    // of what the plant says of a second
constexpr double most_delay = 3, delay_step = 0.005, wrong_delay = 0.5;  // samples
constexpr double hidden =
    0.05;                     // of a gain, its standard deviation: signs and delays are chance then
constexpr double doubts = 4;  // standard deviations beyond which a gain is off

/// What a sampled plant answers to a command on each leg at exp(j w), lines x legs, its own leg
/// alone; and how large the largest answer of another force sensor is beside it, of each leg.
struct Expected {
  MatrixXcd sigma, applied;
  VectorXd others;
};

Expected expected_of(const Gains& gains, const ProbeSettings& settings) {
  const SampledPlant plant = sample_and_hold(gains.loop_plant(), gains.sampling());
  const Index m = gains.n_legs(), n = plant.Phi.rows();
  const auto n_lines = static_cast<Index>(settings.lines.size());
  Expected expected{MatrixXcd::Zero(n_lines, m), MatrixXcd::Zero(n_lines, m), VectorXd::Zero(m)};
  MatrixXd power = MatrixXd::Zero(m, m);  // of sensor i while leg j is driven
  const MatrixXcd Phi = plant.Phi.cast<Complex>();
  for (Index l = 0; l < n_lines; ++l) {
    const double w = two_pi * settings.lines[static_cast<std::size_t>(l)] /
                     static_cast<double>(settings.n_window);
    const Complex z = std::polar(1.0, w);
    for (Index leg = 0; leg < m; ++leg) {
      const Complex late = std::polar(1.0, -w * plant.whole_delay(leg)), later = late / z;
      const VectorXcd drive = plant.Gamma_u.col(leg) * late + plant.Gamma_0.col(leg) * later;
      const VectorXcd x = (z * MatrixXcd::Identity(n, n) - Phi).partialPivLu().solve(drive);
      VectorXcd all = plant.C_sigma * x;
      all += plant.D_sigma.col(leg) * later;
      expected.sigma(l, leg) = all(leg);
      power.col(leg) += all.cwiseAbs2();
      expected.applied(l, leg) =
          ((plant.C_report.row(leg) * x).value() + plant.D_report(leg, leg) * later) *
          std::polar(1.0, -w * plant.report_age);
    }
  }
  for (Index leg = 0; leg < m; ++leg) {
    const double own = power(leg, leg);
    power(leg, leg) = 0;
    expected.others(leg) = std::sqrt(power.col(leg).maxCoeff() / std::max(own, 1e-300));
  }
  return expected;
}

/// The gain with its sign and the delay in samples that fit c_l = gain exp(-j w_l delay).
struct Fit {
  double gain = 0, delay = 0;
};

Fit fit(const VectorXcd& c, const ProbeSettings& settings) {
  Fit best;
  double most = -1;
  for (double delay = -most_delay; delay <= most_delay; delay += delay_step) {
    Complex sum = 0;
    for (Index l = 0; l < c.size(); ++l) {
      sum += c(l) * std::polar(1.0, two_pi * settings.lines[static_cast<std::size_t>(l)] * delay /
                                        static_cast<double>(settings.n_window));
    }
    if (std::abs(sum.real()) <= most) continue;
    most = std::abs(sum.real());
    best = {sum.real() / static_cast<double>(c.size()), delay};
  }
  return best;
}

/// Which channel answers when leg i is driven; -1: none, or more than one. others: what a second
/// may answer by itself, over the first; where that is as much, a channel of its own that answers
/// as awaited is not doubted.
Index answering(const MatrixXcd& read, Index i, const VectorXcd& awaited, double others) {
  const VectorXd size = read.cwiseAbs2().colwise().sum().cwiseSqrt().transpose();
  if (most_beyond * others >= 1) {
    return std::abs(size(i) / awaited.norm() - 1) < second_answer ? i : -1;
  }
  Index largest = 0;
  const double most = size.maxCoeff(&largest);
  if (!(most > least_answer * awaited.norm())) return -1;
  for (Index j = 0; j < size.size(); ++j) {
    if (j != largest && size(j) > std::max(second_answer, most_beyond * others) * most) return -1;
  }
  return largest;
}

void say_gain(LegFinding& finding, const char* what, double gain, double tolerance) {
  if (gain < 0) finding.wrong.push_back(std::string(what) + ": wired the other way round");
  if (std::abs(std::abs(gain) - 1) > tolerance) {
    finding.wrong.push_back(std::string(what) + ": reads " + formatted("%.4g", std::abs(gain)) +
                            " times what it should");
  }
}

/// The channels with the cables where they were found.
std::vector<Channel> put_right(const std::vector<Channel>& channels,
                               const std::vector<LegFinding>& legs,
                               SignalFinding LegFinding::*signal, bool is_force) {
  std::vector<Channel> right = channels;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const SignalFinding& found = legs[i].*signal;
    if (found.cable < 0) continue;
    right[i].number = channels[static_cast<std::size_t>(found.cable)].number;
    // What acts so many times too strongly is to be driven by less; what reads so is to be divided.
    right[i].gain = channels[static_cast<std::size_t>(found.cable)].gain *
                    (is_force ? found.gain : 1 / found.gain);
    right[i].tare = channels[static_cast<std::size_t>(found.cable)].tare;
  }
  return right;
}

/// Whether each cable is that of one leg.
bool is_one_to_one(const std::vector<LegFinding>& legs, SignalFinding LegFinding::*signal) {
  std::vector<bool> taken(legs.size(), false);
  for (const LegFinding& leg : legs) {
    const Index cable = (leg.*signal).cable;
    if (cable < 0 || taken[static_cast<std::size_t>(cable)]) return false;
    taken[static_cast<std::size_t>(cable)] = true;
  }
  return true;
}

}  // namespace

std::vector<int> probe_lines(std::int64_t n_window) {
  const auto first = static_cast<int>(std::ceil(driven_from * static_cast<double>(n_window)));
  const auto last = static_cast<int>(std::floor(driven_up_to * static_cast<double>(n_window)));
  const int step = std::max(1, (last - first) / (most_lines - 1));
  std::vector<int> lines;
  for (int line = first; line <= last; line += step) lines.push_back(line);
  return lines;
}

Wiring wiring_of(const Probe& probe, const ProbeSettings& settings, const Gains& gains,
                 const Channels& channels, double tolerance) {
  const Expected expected = expected_of(gains, settings);
  const Index m = gains.n_legs();
  Wiring wiring;
  wiring.legs.resize(static_cast<std::size_t>(m));
  // What a command on channel i of the rig file drives is known by what answers.
  std::vector<Index> sigma_of(static_cast<std::size_t>(m)), applied_of(sigma_of);
  for (Index i = 0; i < m; ++i) {
    const Response& response = probe.legs[static_cast<std::size_t>(i)];
    sigma_of[static_cast<std::size_t>(i)] =
        answering(response.sigma, i, response.command.cwiseProduct(expected.sigma.col(i)),
                  expected.others(i));
    applied_of[static_cast<std::size_t>(i)] =
        answering(response.applied, i, response.command.cwiseProduct(expected.applied.col(i)), 0);
  }
  for (Index i = 0; i < m; ++i) {
    const Response& response = probe.legs[static_cast<std::size_t>(i)];
    const Index s = sigma_of[static_cast<std::size_t>(i)],
                a = applied_of[static_cast<std::size_t>(i)];
    // The amplifier drives another leg where both its sensors say so; otherwise its own.
    const Index driven = s >= 0 && s == a ? s : i;
    LegFinding& finding = wiring.legs[static_cast<std::size_t>(driven)];
    if (!finding.leg.empty()) wiring.connected = false;
    finding.leg = gains.legs[static_cast<std::size_t>(driven)];
    // Before anything is made of what answers: of the quietest sensor.
    if (!(response.sigma_scatter.minCoeff() <
          hidden * response.command.cwiseAbs().mean() *
              std::sqrt(static_cast<double>(response.command.size())))) {
      finding.wrong.push_back("noise hides what it answers: take a larger --force");
      wiring.connected = false;
      continue;
    }
    finding.sigma_mean = probe.rest.sigma_mean(s < 0 ? driven : s);
    finding.sigma_noise = probe.rest.sigma_scatter(s < 0 ? driven : s);
    finding.force.cable = i;
    finding.sigma.cable = s;
    finding.applied.cable = a;
    const auto name = [&](Index leg) { return gains.legs[static_cast<std::size_t>(leg)]; };
    if (driven != i) finding.wrong.push_back("amplifier: on the cable of " + name(i));
    if (s >= 0 && s != driven) finding.wrong.push_back("force sensor: on the cable of " + name(s));
    if (a >= 0 && a != driven) finding.wrong.push_back("read-back: on the cable of " + name(a));
    if (s < 0 && a < 0) {
      finding.wrong.push_back(
          "neither force sensor nor read-back answers: amplifier, actuator or cable");
      wiring.connected = false;
      continue;
    }
    if (s < 0) finding.wrong.push_back("force sensor: does not answer, or more than one does");
    if (a < 0) finding.wrong.push_back("read-back: does not answer, or more than one does");
    if (s < 0 || a < 0) {
      wiring.connected = false;
      continue;
    }
    const VectorXcd u = response.command;
    const VectorXcd sigma =
        response.sigma.col(s).cwiseQuotient(u.cwiseProduct(expected.sigma.col(driven)));
    const VectorXcd applied =
        response.applied.col(a).cwiseQuotient(u.cwiseProduct(expected.applied.col(driven)));
    const Fit of_sigma = fit(sigma, settings), of_applied = fit(applied, settings);
    finding.doubt = response.sigma_scatter(s) /
                    (u.cwiseAbs().mean() * std::sqrt(static_cast<double>(u.size())));
    finding.delay_samples = of_sigma.delay;
    const double allowed = std::max(tolerance, doubts * finding.doubt);
    const auto is_one = [&](double gain) { return std::abs(gain - 1) <= allowed; };
    // Signs by themselves, beside a gain that is off as well: what turns both is the amplifier.
    const double r_s = std::abs(of_sigma.gain), r_a = std::abs(of_applied.gain);
    if (is_one(r_s)) {
      finding.applied.gain = is_one(r_a) ? 1 : r_a;
    } else if (is_one(r_a)) {
      finding.sigma.gain = r_s;
    } else {
      finding.force.gain = r_a;
      finding.sigma.gain = is_one(r_s / r_a) ? 1 : r_s / r_a;
    }
    if (of_sigma.gain < 0 && of_applied.gain < 0) {
      finding.force.gain = -finding.force.gain;
    } else {
      finding.sigma.gain = std::copysign(finding.sigma.gain, of_sigma.gain);
      finding.applied.gain = std::copysign(finding.applied.gain, of_applied.gain);
    }
    say_gain(finding, "force sensor", finding.sigma.gain, allowed);
    say_gain(finding, "read-back", finding.applied.gain, allowed);
    say_gain(finding, "amplifier", finding.force.gain, allowed);
    if (std::abs(of_sigma.delay) > wrong_delay) {
      finding.wrong.push_back("answers " + formatted("%+.2f", of_sigma.delay) +
                              " samples from when the gains say");
      wiring.mended = false;
    }
    if (std::abs(of_applied.delay - of_sigma.delay) > wrong_delay) {
      finding.wrong.push_back(
          "read-back: " + formatted("%+.2f", of_applied.delay - of_sigma.delay) +
          " samples from the force sensor, other than the gains say");
      wiring.mended = false;
    }
  }
  for (Index i = 0; i < m; ++i) {
    LegFinding& finding = wiring.legs[static_cast<std::size_t>(i)];
    if (finding.leg.empty()) {
      finding.leg = gains.legs[static_cast<std::size_t>(i)];
      finding.wrong.push_back("no amplifier drives it");
    }
    if (!finding.wrong.empty()) wiring.sound = false;
  }
  wiring.channels = channels;
  wiring.connected = wiring.connected && is_one_to_one(wiring.legs, &LegFinding::sigma) &&
                     is_one_to_one(wiring.legs, &LegFinding::applied) &&
                     is_one_to_one(wiring.legs, &LegFinding::force);
  wiring.mended = wiring.mended && wiring.connected;
  if (wiring.connected) {
    wiring.channels.sigma = put_right(channels.sigma, wiring.legs, &LegFinding::sigma, false);
    wiring.channels.applied = put_right(channels.applied, wiring.legs, &LegFinding::applied, false);
    wiring.channels.force = put_right(channels.force, wiring.legs, &LegFinding::force, true);
  }
  return wiring;
}

}  // namespace stillframe::controller
