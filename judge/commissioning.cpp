#include "judge/commissioning.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "controller/excitation.hpp"
#include "controller/rig/scaled_io.hpp"
#include "core/control/fitting/acted_commands.hpp"
#include "core/control/fitting/rig_model.hpp"
#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/resonances.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "core/yaml/quoted.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe::judge {

using controller::Channels;
using controller::ProbeSettings;
using controller::Recording;
using controller::RigFile;
using Eigen::Index;
using Eigen::VectorXd;
using robustness::Parameter;
using Kind = Parameter::Kind;

namespace {

constexpr double off_resonance = 0.08;
constexpr std::size_t fewest_lines = 8;
constexpr Index most_window = 1'000'000, most_recorded = 5'000'000;  // samples
constexpr double gross_gain = 1.5;  // of a card at another range, say
// Of what is as likely anywhere between -1 and 1.
const double deviation_of_even = 1 / std::sqrt(3.0);
// Of a recording, each with so much less force than the one before.
constexpr int most_attempts = 3;
constexpr double less_force = 4;
constexpr double told = 0.5, correlated = 0.9;

/// A correction is of a node, whatever stands there.
void refuse_shared_nodes(const Scene& scene) {
  for (std::size_t i = 0; i < scene.masses.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (scene.masses[i].node != scene.masses[j].node) continue;
      throw InputError(scene.masses[i].place + ": node '" + scene.masses[i].node +
                       "' has two masses, which no measurement tells apart; make them one");
    }
  }
}

/// Whether the rig measures all accelerations of the floor that the scene has, in their order.
bool measures_floor(const RigFile& rig, const Scene& scene) {
  return std::ranges::equal(rig.floor, scene.inputs, {}, {}, &SceneSignal::name);
}

/// What is applied over what is commanded of each leg: a gain that no force sensor sees.
class ReadBack {
 public:
  ReadBack(const fitting::RigRecord& record, const std::vector<bool>& driven,
           const fitting::FitQuestion& question)
      : record_(record), question_(question), kernel_(record.n_window, record.lines, 0) {
    for (std::size_t w = 0; w < driven.size(); ++w) {
      if (!driven[w]) continue;
      windows_.emplace_back(record, static_cast<Index>(w),
                            question.sampling.instruments.report_age_samples, kernel_);
    }
  }

  /// By the delay that what is read back goes with best; no mass and no stiffness has a part in it.
  VectorXd gains() const {
    const auto of_delay = std::ranges::find(question_.parameters, Kind::delay, &Parameter::kind);
    const double nominal = question_.sampling.delay_samples;
    double best = nominal;
    double reach = of_delay == question_.parameters.end() ? 0 : 2 * of_delay->size;
    double most = of_delay == question_.parameters.end() ? 1 : -1;
    for (int pass = 0; pass < 3 && reach > 0; ++pass, reach /= 10) {
      const double centre = best;
      for (int i = -20; i <= 20; ++i) {
        const double delay = centre + reach * i / 20;
        if (delay < 0 || delay > longest_delay_samples) continue;
        const double likeness = compared(delay).second;
        if (likeness <= most) continue;
        most = likeness;
        best = delay;
      }
    }
    return compared(best).first;
  }

 private:
  /// The gains with a delay, and how much of what is read they explain.
  std::pair<VectorXd, double> compared(double delay) const {
    Sampling sampling = question_.sampling;
    sampling.delay_samples = delay;
    const fitting::RigModel model(robustness::sampled({question_.scene, sampling}), record_, {},
                                  kernel_);
    const Index m = record_.command.cols();
    VectorXd along = VectorXd::Zero(m), expected = along, read = along;
    for (const fitting::WindowData& window : windows_) {
      const Eigen::MatrixXcd e = model.predicted(window).middleRows(m, m),
                             r = window.read().middleRows(m, m);
      along += e.conjugate().cwiseProduct(r).real().rowwise().sum();
      expected += e.cwiseAbs2().rowwise().sum();
      read += r.cwiseAbs2().rowwise().sum();
    }
    const VectorXd gains = along.cwiseQuotient(expected.cwiseMax(1e-300));
    return {gains, along.dot(gains) / std::max(read.sum(), 1e-300)};
  }

  const fitting::RigRecord& record_;
  const fitting::FitQuestion& question_;
  fitting::LineKernel kernel_;
  std::vector<fitting::WindowData> windows_;
};

/// A channel of a driver that gives no numbers.
void require_numbers(const Commissioned& found) {
  const auto require = [](const Eigen::MatrixXd& values, const char* kind,
                          const std::vector<std::string>& names) {
    for (Index i = 0; i < values.cols(); ++i) {
      if (values.col(i).allFinite()) continue;
      throw std::runtime_error(std::string(kind) + " " + names[static_cast<std::size_t>(i)] +
                               " gave what is no number");
    }
  };
  const auto& legs = found.question.scene.controller->legs;
  require(found.recording.sigma, "force sensor", legs);
  require(found.recording.applied, "read-back", legs);
  require(found.recording.frame, "accelerometer", found.rig.frame);
  require(found.recording.floor, "accelerometer", found.rig.floor);
}

/// How a channel moves through a window; samples that did not come have no part in it.
struct Motion {
  Index changes = 0;
  Index longest = 0, begins = 0;  ///< samples that it stands still, and the first of them
};

Motion motion_of(const Recording& recording, const Eigen::MatrixXd& values, Index column,
                 Index from, Index n) {
  Motion motion;
  Index last = -1, since = from;
  for (Index k = from; k < from + n; ++k) {
    if (recording.missing[static_cast<std::size_t>(k)]) continue;
    if (last >= 0 && values(k, column) != values(last, column)) {
      ++motion.changes;
      since = k;
    }
    last = k;
    if (k + 1 - since > motion.longest) {
      motion.longest = k + 1 - since;
      motion.begins = since;
    }
  }
  return motion;
}

/// The changes in most of these windows, 0 without any.
Index usual_changes(std::vector<Index> changes) {
  if (changes.empty()) return 0;
  const auto middle = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 2);
  std::ranges::nth_element(changes, middle);
  return *middle;
}

/// The channels put right, but for gains that a plant with another delay or lag may feign.
Channels without_small_gains(const Channels& before, const controller::Wiring& wiring) {
  Channels channels = wiring.channels;
  const auto forget = [](std::vector<controller::Channel>& right,
                         const std::vector<controller::Channel>& was) {
    for (controller::Channel& channel : right) {
      const auto of_cable = std::ranges::find(was, channel.number, &controller::Channel::number);
      const double factor = std::abs(channel.gain / of_cable->gain);
      if (factor < gross_gain && factor > 1 / gross_gain) {
        channel.gain = std::copysign(of_cable->gain, channel.gain);
      }
    }
  };
  forget(channels.sigma, before.sigma);
  forget(channels.applied, before.applied);
  forget(channels.force, before.force);
  return channels;
}

/// The gains that were fitted, in the channels: forces that act as they are commanded, sensors
/// that read what there is.
void put_gains(const Commissioned& found, Channels& channels) {
  for (std::size_t i = 0; i < channels.force.size(); ++i) {
    channels.force[i].gain *= found.read_back(static_cast<Index>(i));
  }
  for (std::size_t i = 0; i < found.question.parameters.size(); ++i) {
    const Parameter& parameter = found.question.parameters[i];
    const double factor = 1 + found_deviation(found, i);
    if (parameter.kind == Kind::actuator_gain) {
      channels.force[parameter.index].gain *= factor;
      channels.applied[parameter.index].gain *= factor;
    }
    if (parameter.kind == Kind::sensor_gain) channels.sigma[parameter.index].gain /= factor;
  }
}

/// What the force sensors read while nothing is driven is taken out of them: of a frame that rings
/// on for minutes, arming cannot tell it in half a second, and a law makes hundreds of times as
/// much of it. Through a window of Hann, of which ringing is no part.
void put_tares(const Recording& recording, Index n_window,
               std::vector<controller::Channel>& sigma) {
  const auto n_rest = std::ranges::count(recording.driven, -1);
  const Index from = recording.windows.front(),
              n = recording.windows[static_cast<std::size_t>(n_rest - 1)] + n_window - from;
  const Eigen::ArrayXd turns = Eigen::ArrayXd::LinSpaced(n, 0, two_pi);
  const VectorXd weights = (1 - turns.cos()).matrix() / (1 - turns.cos()).sum();
  const VectorXd mean = recording.sigma.middleRows(from, n).transpose() * weights;
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    sigma[i].tare += mean(static_cast<Index>(i)) / sigma[i].gain;
  }
}

/// Of the output of which it is least, over all lines.
double over_rest_db(const fitting::RigRecord& record, const std::vector<bool>& driven) {
  const fitting::LineKernel kernel(record.n_window, record.lines, 0);
  VectorXd power[2];
  for (std::size_t w = 0; w < driven.size(); ++w) {
    const fitting::WindowData data(record, static_cast<Index>(w), 0, kernel);
    const VectorXd each = data.read().cwiseAbs2().rowwise().sum();
    VectorXd& sum = power[driven[w]];
    sum = sum.size() == 0 ? each : VectorXd(sum.cwiseMax(each));
  }
  return 10 * std::log10((power[1].cwiseQuotient(power[0].cwiseMax(1e-300))).minCoeff());
}

Index window_samples(const LoopDesign& design, double window_s) {
  const double samples = std::round(window_s * design.gains.sample_rate_hz);
  return static_cast<Index>(std::min(samples, 1e15));
}

}  // namespace

std::vector<Index> outputs_of(const RigFile& rig, const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneSignal& output : scene.outputs) names.push_back(output.name);
  std::vector<Index> places;
  for (const std::string& name : rig.frame) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
      const std::string near = nearest_name(name, names);
      std::string allowed;
      for (const std::string& other : names) allowed += (allowed.empty() ? "" : ", ") + other;
      throw InputError(rig.place_of("frame." + name) + ": is no output of the scene" +
                       (near.empty() ? "" : " (did you mean '" + near + "'?)") + "; allowed are " +
                       allowed);
    }
    places.push_back(found - names.begin());
  }
  return places;
}

std::vector<int> commission_lines(const judge::LoopDesign& design, Index n_window) {
  const double rate_hz = design.gains.sample_rate_hz;
  // As it is given, in seconds.
  const std::string found = formatted("--window: found %.4g s at %g Hz",
                                      static_cast<double>(n_window) / rate_hz, rate_hz);
  if (n_window > most_window) {
    throw InputError(
        found + formatted(", allowed is up to %g s", static_cast<double>(most_window) / rate_hz));
  }
  const double df = rate_hz / static_cast<double>(n_window);
  const Eigen::VectorXcd poles = design.settings.plant.A.eigenvalues();
  const std::vector<Resonance> at = resonances(poles);
  const auto near_resonance = [&](double hz) {
    return std::ranges::any_of(at, [&](const Resonance& resonance) {
      return std::abs(hz - resonance.hz) < off_resonance * resonance.hz;
    });
  };
  std::vector<int> lines = controller::logarithmic_lines(
      controller::lowest_line, controller::driven_up_to * static_cast<double>(n_window),
      static_cast<int>(controller::usual_lines),
      [&](int line) { return near_resonance(line * df); });
  if (lines.size() < fewest_lines) {
    throw InputError(found + formatted(", which has %zu lines beside the resonances and needs %zu; "
                                       "allowed are longer ones",
                                       lines.size(), fewest_lines));
  }
  return lines;
}

void require_recordable(const LoopDesign& design, double window_s, int n_windows) {
  const Index n_window = window_samples(design, window_s), m = design.gains.n_legs();
  commission_lines(design, n_window);
  // As record_rig makes it: a drive rises for a window and falls for one.
  const Index n_recorded = (2 * n_windows + (n_windows + 2) * m) * n_window;
  if (n_recorded > most_recorded) {
    const double rate_hz = design.gains.sample_rate_hz;
    throw InputError(
        formatted("--window, --windows: found %d of %g s, a recording of %.6g s; allowed "
                  "is one of up to %g s at %g Hz",
                  n_windows, window_s, static_cast<double>(n_recorded) / rate_hz,
                  static_cast<double>(most_recorded) / rate_hz, rate_hz));
  }
}

void require_motion(const Recording& recording, Index n_window, double sample_rate_hz,
                    const std::vector<std::string>& legs, const RigFile& rig) {
  // Noise about one step of a converter changes its reading now and then: of a hundred changes in a
  // window, none for a quarter of it is chance once in 1e9 times.
  constexpr Index fewest_changes = 100, most_still = 4;
  const auto require = [&](const Eigen::MatrixXd& values, const char* kind,
                           const std::vector<std::string>& names) {
    for (Index i = 0; i < values.cols(); ++i) {
      std::vector<Motion> motions;
      for (const Index from : recording.windows) {
        motions.push_back(motion_of(recording, values, i, from, n_window));
      }
      const auto usual = [&](Index driven, std::size_t but) {
        std::vector<Index> changes;
        for (std::size_t w = 0; w < motions.size(); ++w) {
          if (w != but && recording.driven[w] == driven) changes.push_back(motions[w].changes);
        }
        return usual_changes(std::move(changes));
      };
      const bool is_dead =
          std::ranges::all_of(motions, [](const Motion& motion) { return motion.changes == 0; });
      if (is_dead && &values == &recording.frame) {
        throw std::runtime_error(
            formatted("%s %s stood still throughout: connect it, or take it out "
                      "of the rig file",
                      kind, names[static_cast<std::size_t>(i)].c_str()));
      }
      for (std::size_t w = 0; w < motions.size(); ++w) {
        if (recording.driven[w] < 0 || most_still * motions[w].longest < n_window) continue;
        if (std::max(usual(recording.driven[w], w), usual(-1, w)) < fewest_changes) continue;
        throw std::runtime_error(
            formatted("%s %s stood still for %.3g s, from %.3g s of the recording on: is it stuck?",
                      kind, names[static_cast<std::size_t>(i)].c_str(),
                      static_cast<double>(motions[w].longest) / sample_rate_hz,
                      static_cast<double>(motions[w].begins) / sample_rate_hz));
      }
    }
  };
  require(recording.sigma, "force sensor", legs);
  require(recording.applied, "read-back", legs);
  require(recording.frame, "accelerometer", rig.frame);
  require(recording.floor, "accelerometer", rig.floor);
}

Commissioned measure(controller::Io& io, const RigFile& rig, const CommissionQuestion& question,
                     const controller::ProbeTime& time, const Progress& progress,
                     const std::function<bool()>& stop) {
  const judge::LoopDesign& design = question.design;
  const Index m = design.gains.n_legs();
  refuse_shared_nodes(design.scene);
  Commissioned found;
  found.rig = rig;
  found.question = {.scene = design.scene,
                    .sampling = design.settings.sampling,
                    .parameters = robustness::parameters_of(design.scene, question.uncertainty),
                    .frame = outputs_of(rig, design.scene)};
  if (found.question.parameters.empty() && !question.only_wiring) {
    const std::string& place = question.uncertainty.place;
    throw InputError((place.empty() ? design.scene.file : place) +
                     ": uncertainty: nothing of this scene is uncertain; give at least one of its "
                     "values above 0");
  }
  for (Parameter& parameter : found.question.parameters) parameter.size *= deviation_of_even;
  require_recordable(design, question.window_s, question.n_windows);  // before anything moves
  const Index n_window = window_samples(design, question.window_s);
  const std::vector<int> lines = commission_lines(design, n_window);
  ProbeSettings settings = controller::probe_settings(design.gains, rig.channels, question.force_n);
  const auto wiring_now = [&](const char* what) {
    controller::ScaledIo scaled(io, found.rig.channels);
    const auto probe = controller::probe_rig(
        scaled, m, settings, time, [&](double done) { progress(what, done); }, stop);
    return wiring_of(probe, settings, design.gains, found.rig.channels);
  };
  found.wiring = wiring_now("wiring");
  if (!found.wiring.sound) {
    if (!found.wiring.connected) return found;
    found.rig.channels = without_small_gains(found.rig.channels, found.wiring);
    const controller::Wiring again = wiring_now("wiring, once more");
    // What is found beside a cable that was wrong may be found better now; what is still wrong is
    // beyond a rig file.
    if (!again.connected) {
      found.wiring.connected = false;
      return found;
    }
    found.rig.channels = without_small_gains(found.rig.channels, again);
  }
  if (question.only_wiring) return found;
  settings.n_window = n_window;
  settings.n_windows = question.n_windows;
  settings.lines = lines;
  // A line that happens to be on a resonance of the rig, which nobody knows before, makes an
  // undamped frame ring further and further: with less force it rings as much less, within the same
  // bound.
  for (int attempt = 1;; ++attempt) {
    controller::ScaledIo scaled(io, found.rig.channels);
    try {
      found.recording = controller::record_rig(
          scaled, m, settings, time, [&](double done) { progress("recording", done); }, stop);
      break;
    } catch (const controller::TooFar&) {
      if (attempt == most_attempts) throw;
      settings.force_n /= less_force;
    }
  }
  found.force_n = settings.force_n;
  found.lines = lines;
  found.n_window = n_window;
  require_numbers(found);
  require_motion(found.recording, n_window, design.gains.sample_rate_hz, design.gains.legs, rig);
  return found;
}

void fit_recording(Commissioned& found, const Progress& progress) {
  const Recording& recording = found.recording;
  fitting::ActedCommands acted =
      fitting::acted_commands(recording.command, recording.applied, recording.missing);
  found.n_late = acted.n_late;
  fitting::RigRecord record{
      .sample_time = found.question.sampling.sample_time * (1 + recording.drift),
      .command = std::move(acted.command),
      .sigma = recording.sigma,
      .applied = recording.applied,
      .frame = recording.frame,
      .floor = measures_floor(found.rig, found.question.scene)
                   ? recording.floor
                   : Eigen::MatrixXd(recording.floor.rows(), 0),
      .windows = recording.windows,
      .n_window = found.n_window,
      .missing = recording.missing,
      .lines = found.lines};
  found.question.sampling.sample_time = record.sample_time;
  std::vector<bool> driven;
  for (const Index leg : recording.driven) driven.push_back(leg >= 0);
  found.read_back = ReadBack(record, driven, found.question).gains();
  record.command *= found.read_back.asDiagonal();
  found.disturbance_db = over_rest_db(record, driven);
  found.fit = fitting::fit_rig(found.question, record, driven,
                               [&](double done) { progress("fitting", done); });
  put_tares(recording, found.n_window, found.rig.channels.sigma);
  put_gains(found, found.rig.channels);
}

double found_deviation(const Commissioned& found, std::size_t i) {
  return found.question.parameters[i].size * found.fit.values(static_cast<Index>(i));
}

double found_doubt(const Commissioned& found, std::size_t i) {
  return found.question.parameters[i].size * found.fit.deviation(static_cast<Index>(i));
}

double known_before(const Commissioned& found, std::size_t i) {
  return found.question.parameters[i].size / deviation_of_even;
}

bool is_told(const Commissioned& found, std::size_t i) {
  return found.fit.deviation(static_cast<Index>(i)) < told;
}

bool anything_told(const Commissioned& found) {
  for (std::size_t i = 0; i < found.question.parameters.size(); ++i) {
    if (is_told(found, i)) return true;
  }
  return false;
}

VectorXd frame_peak(const Commissioned& found) {
  const Recording& recording = found.recording;
  VectorXd peak = VectorXd::Zero(recording.frame.cols());
  if (recording.windows.empty()) return peak;
  // The windows at rest come first.
  const auto rest = recording.frame.middleRows(recording.windows.front(), found.n_window);
  const Eigen::RowVectorXd mean = rest.colwise().mean();
  peak = (recording.frame.rowwise() - mean).cwiseAbs().colwise().maxCoeff().transpose();
  return peak;
}

std::vector<std::size_t> alike(const Commissioned& found, std::size_t i) {
  std::vector<std::size_t> others;
  for (std::size_t j = 0; j < found.question.parameters.size(); ++j) {
    if (j == i) continue;
    const double r = found.fit.correlation(static_cast<Index>(i), static_cast<Index>(j));
    if (std::abs(r) >= correlated) others.push_back(j);
  }
  return others;
}

std::string corrections_block(const Commissioned& found) {
  // By key, then by part, in the order of the parameters.
  std::vector<std::pair<std::string, std::vector<std::pair<std::string, std::vector<double>>>>>
      keys;
  const auto add = [&](const std::string& key, const std::string& subject, double value) {
    if (keys.empty() || keys.back().first != key) keys.push_back({key, {}});
    auto& parts = keys.back().second;
    if (parts.empty() || parts.back().first != subject) parts.push_back({subject, {}});
    parts.back().second.push_back(value);
  };
  std::string delay;
  for (std::size_t i = 0; i < found.question.parameters.size(); ++i) {
    const Parameter& parameter = found.question.parameters[i];
    // To two digits of its doubt: what is rounded off is in no band.
    const double unit = std::pow(10, std::floor(std::log10(found_doubt(found, i))) - 1);
    const double value = unit * std::round(found_deviation(found, i) / unit);
    const double rounded = std::strtod(formatted("%.12g", value).c_str(), nullptr);
    if (parameter.kind == Kind::actuator_gain || parameter.kind == Kind::sensor_gain) {
      continue;  // of the rig file
    }
    if (parameter.kind == Kind::delay) {
      delay = "  delay_samples: " + shortest_digits(rounded) + "\n";
    } else {
      add(key_of(parameter.kind), parameter.subject, rounded);
    }
  }
  if (keys.empty() && delay.empty()) return "corrections: {}\n";
  std::string text = "corrections:\n";
  for (const auto& [key, parts] : keys) {
    const bool is_list = key == "centre_of_mass_m" || key == "leg_direction_rad";
    text += "  " + key + ":\n";
    for (const auto& [subject, values] : parts) {
      text += "    " + quoted(subject) + ": " + (is_list ? "[" : "");
      for (std::size_t i = 0; i < values.size(); ++i) {
        text += (i > 0 ? ", " : "") + shortest_digits(values[i]);
      }
      text += is_list ? "]\n" : "\n";
    }
  }
  return text + delay;
}

std::string uncertainty_left(const Commissioned& found) {
  std::vector<std::pair<std::string, double>> keys;
  for (std::size_t i = 0; i < found.question.parameters.size(); ++i) {
    const std::string key = key_of(found.question.parameters[i].kind);
    const double doubt = std::min(2 * found_doubt(found, i), known_before(found, i));
    if (keys.empty() || keys.back().first != key) keys.push_back({key, 0});
    keys.back().second = std::max(keys.back().second, doubt);
  }
  std::string text;
  for (const auto& [key, value] : keys) {
    text += formatted("%s: %.2g\n", key.c_str(), value);
  }
  return text;
}

}  // namespace stillframe::judge
