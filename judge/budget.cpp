#include "judge/budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "controller/start_check.hpp"
#include "core/systems/noise_power.hpp"
#include "judge/budget_loops.hpp"
#include "plant_sim/force_courses.hpp"
#include "plant_sim/sensor_errors.hpp"
#include "report/analysis/loop_response.hpp"
#include "report/spectra/running_power.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const char* name_of(BudgetMethod method) {
  return method == BudgetMethod::passive    ? "passive"
         : method == BudgetMethod::feedback ? "feedback"
                                            : "feed_forward";
}

const MethodBudget* Budget::of(BudgetMethod method) const {
  const auto found = std::find_if(methods.begin(), methods.end(),
                                  [&](const MethodBudget& one) { return one.method == method; });
  return found == methods.end() ? nullptr : &*found;
}

namespace {

// Cells in a third octave, and third octaves below that of 1 Hz, where cells begin behind 0 Hz.
constexpr Index cells_a_band = 4, bands_below = 10;
constexpr Index first_band = 1 + cells_a_band * bands_below;

VectorXd cell_edges(double sample_rate_hz) {
  std::vector<double> edges{0};
  const double half = sample_rate_hz / 2;
  for (Index i = -cells_a_band * bands_below;; ++i) {
    const double edge = std::pow(10, -0.05 + 0.1 * static_cast<double>(i) / cells_a_band);
    if (!(edge < half * (1 - 1e-9))) break;
    edges.push_back(edge);
  }
  edges.push_back(half);
  return Eigen::Map<const VectorXd>(edges.data(), std::ssize(edges));
}

/// The power of an acceleration by cells and bands.
struct Levels {
  double mean_square = 0;
  VectorXd power, velocity;
};

/// Of a course. What is constant in it is in the cell of 0 Hz.
Levels levels_of(const VectorXd& course, double sample_rate_hz, const VectorXd& edges_hz) {
  Levels levels{.mean_square = course.squaredNorm() / static_cast<double>(course.size()),
                .power = VectorXd::Zero(edges_hz.size() - 1),
                .velocity = {}};
  const report::Psd psd = report::power_of(course, sample_rate_hz);
  if (psd.density.size() == 0) {
    levels.power(0) = levels.mean_square;
    levels.velocity.setConstant(std::ssize(report::third_octave_bands()),
                                std::numeric_limits<double>::quiet_NaN());
    return levels;
  }
  levels.power = report::band_powers(psd, edges_hz);
  levels.power(0) += levels.mean_square - levels.power.sum();
  levels.velocity = report::third_octave_velocity(psd);
  return levels;
}

/// Of a noise, at what it is expected to have over the run.
Levels levels_of(const NoisePower& noise, Index output, double mean_square) {
  const double settled = noise.power.row(output).sum();
  const double part = settled > 0 ? mean_square / settled : 0;
  Levels levels{.mean_square = settled > 0 ? mean_square : 0,
                .power = part * noise.power.row(output).transpose(),
                .velocity = {}};
  const Index n_bands = std::ssize(report::third_octave_bands());
  levels.velocity.setConstant(n_bands, std::numeric_limits<double>::quiet_NaN());
  for (Index band = 0; band < n_bands; ++band) {
    const Index cell = first_band + cells_a_band * band;
    if (cell + cells_a_band > noise.power.cols()) break;  // the last one is cut at half the rate
    levels.velocity(band) =
        std::sqrt(part * noise.integrated.row(output).segment(cell, cells_a_band).sum());
  }
  return levels;
}

BudgetPart part_of(const Levels& levels) {
  return {.rms = std::sqrt(levels.mean_square),
          .share = levels.mean_square,
          .power = levels.power,
          .shared = levels.power,
          .velocity = levels.velocity};
}

/// Something whose every number is known: measurement k holds what row k did.
struct Course {
  std::string name;
  MatrixXd inputs;  ///< n x inputs of the loop
  std::function<SampledLoop(BudgetMethod)> loop;
};

/// Something whose density is known, and its mean square over the run.
struct Noise {
  std::string name;
  NoisePower power;
  VectorXd mean_square;
  bool feed_forward;  ///< acts through it alone
};

class Maker {
 public:
  Maker(const LoopDesign& design, const floor::FloorSpec& spec, const BudgetPlan& plan)
      : design_(design), plan_(plan), T_(design.gains.sample_time()) {
    controller::require_stable(design.gains);
    auto source = floor::make_floor_source(spec);
    const floor::FloorSource& floor = *source;
    const FloorMotion motion(std::move(source), design.scene, design.model);
    for (const ComparedFrame& axis : plan.axes) outputs_.push_back(axis.frame);
    for (const ComparedFrame& axis : plan.axes) {
      if (!axis.floor.empty()) outputs_.push_back(axis.floor);
    }
    loops_.emplace(design, motion, outputs_);
    edges_hz_ = cell_edges(design.gains.sample_rate_hz);
    add_floor(floor);
    add_forces();
    add_sensors();
  }

  Budget make() {
    Budget budget{.sample_rate_hz = design_.gains.sample_rate_hz,
                  .n_samples = plan_.n_samples,
                  .axes = plan_.axes,
                  .sources = {},
                  .edges_hz = edges_hz_,
                  .methods = {},
                  .floors = {},
                  .left_out = left_out()};
    for (const Course& course : courses_) budget.sources.push_back(course.name);
    for (const Noise& noise : noises_) budget.sources.push_back(noise.name);
    std::vector<BudgetMethod> methods{BudgetMethod::passive, BudgetMethod::feedback};
    if (!design_.gains.heard_floor().empty()) methods.push_back(BudgetMethod::feed_forward);
    const Index n_axes = std::ssize(plan_.axes);
    n_to_do_ = std::ssize(methods) * n_axes + std::ssize(outputs_) - n_axes;
    for (const BudgetMethod method : methods) {
      const std::vector<MatrixXd> responses = responses_to(method);
      MethodBudget made{.method = method, .axes = {}};
      for (Index i = 0; i < n_axes; ++i) made.axes.push_back(budget_of(responses, i, method));
      budget.methods.push_back(std::move(made));
      if (method == BudgetMethod::passive) budget.floors = floors_of(responses);
    }
    return budget;
  }

 private:
  Index n() const { return plan_.n_samples; }

  void add_floor(const floor::FloorSource& floor) {
    VectorXd sample = VectorXd::Zero(floor.channels());
    std::vector<Index> channels;
    for (Index c = 0; c < floor.channels(); ++c) {
      if (!floor.moves(c)) continue;
      channels.push_back(c);
      courses_.push_back({"floor " + channel_name(floor, c), MatrixXd::Zero(n(), 1),
                          [this, c](BudgetMethod method) { return loops_->of_floor(c, method); }});
    }
    for (Index k = 1; k < n(); ++k) {
      floor.sample(k - 1, sample);
      for (std::size_t i = 0; i < channels.size(); ++i) {
        courses_[i].inputs(k, 0) = sample(channels[i]);
      }
    }
  }

  std::string channel_name(const floor::FloorSource& floor, Index channel) const {
    const bool rigid = floor.meaning() != floor::FloorChannels::inputs;
    const Index n_axes = std::ssize(floor::axis_names);
    if (rigid && channel < n_axes) {
      return std::string(floor::axis_names[static_cast<std::size_t>(channel)]);
    }
    return design_.scene.inputs[static_cast<std::size_t>(channel - (rigid ? n_axes : 0))].name;
  }

  void add_forces() {
    for (std::size_t i = 0; i < design_.scene.disturbances.size(); ++i) {
      const SceneDisturbance& disturbance = design_.scene.disturbances[i];
      const ForceCourse course(disturbance, T_);
      MatrixXd inputs = MatrixXd::Zero(n(), 1);
      for (Index k = 1; k < n(); ++k) inputs(k, 0) = course.at(k - 1);
      courses_.push_back(
          {"force " + disturbance.name, std::move(inputs), [this, i](BudgetMethod method) {
             return loops_->of_force(static_cast<Index>(i), method);
           }});
    }
  }

  void add_sensors() {
    const Instruments& instruments = design_.gains.instruments;
    if (const auto& errors = instruments.force_sensors) add_force_sensors(*errors);
    const bool heard = !design_.gains.heard_floor().empty();
    if (!heard || !instruments.floor_sensors || instruments.floor_sensors->noise == 0) return;
    add_noises(loops_->of_floor_sensors(),
               {{"floor sensors, noise", {process_of(*instruments.floor_sensors, T_)}}}, true);
  }

  void add_force_sensors(const ForceSensorErrors& errors) {
    const LinearSystem loop = loops_->of_force_sensors();
    const Index m = loop.B.cols();
    const VectorXd offset = per_leg(errors.offset, m), drift = per_leg(errors.drift, m);
    if (!offset.isZero(0) || !drift.isZero(0)) {
      MatrixXd inputs = MatrixXd::Zero(n(), m);
      for (Index k = 1; k < n(); ++k) {
        inputs.row(k) = (offset + static_cast<double>(k - 1) * T_ * drift).transpose();
      }
      courses_.push_back(
          {"force sensors, offset and drift", std::move(inputs), [this, loop](BudgetMethod method) {
             SampledLoop result{.A = loop.A,
                                .B = loop.B,
                                .B_v = {},
                                .C = loop.C,
                                .D = loop.D,
                                .D_v = {},
                                .n_exogenous = 0,
                                .sample_time = T_};
             if (method == BudgetMethod::passive) {
               result.C.setZero();
               result.D.setZero();
             }
             return result;
           }});
    }
    const ForceSensorProcesses processes =
        processes_of(errors, T_, design_.gains.instruments.sensor_filter_hz);
    std::vector<std::pair<std::string, NoiseKind>> kinds;
    if (errors.noise > 0) kinds.push_back({"force sensors, noise", {processes.noise}});
    if (!processes.flicker.empty()) kinds.push_back({"force sensors, flicker", processes.flicker});
    if (errors.random_walk > 0) kinds.push_back({"force sensors, walk", {processes.walk}});
    if (errors.quantisation > 0) {
      kinds.push_back(
          {"force sensors, steps", {NoiseProcess::white(errors.quantisation / std::sqrt(12.0))}});
    }
    add_noises(loop, kinds, false);
  }

  static VectorXd per_leg(const std::vector<double>& numbers, Index m) {
    if (std::ssize(numbers) == m) return Eigen::Map<const VectorXd>(numbers.data(), m);
    return VectorXd::Constant(m, numbers.empty() ? 0 : numbers.front());
  }

  void add_noises(const LinearSystem& loop,
                  const std::vector<std::pair<std::string, NoiseKind>>& named, bool feed_forward) {
    std::vector<NoiseKind> kinds;
    for (const auto& [name, kind] : named) kinds.push_back(kind);
    const std::vector<NoisePower> powers = noise_power(loop, kinds, T_, edges_hz_);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      VectorXd mean_square = VectorXd::Zero(loop.C.rows());
      // The first measurement is of a frame at rest.
      const double behind_it = static_cast<double>(n() - 1) / static_cast<double>(n());
      for (const NoiseProcess& process : kinds[i]) {
        if (n() > 1) mean_square += behind_it * mean_square_over(loop, process, n() - 1);
      }
      noises_.push_back({named[i].first, powers[i], mean_square, feed_forward});
    }
  }

  /// n x outputs of every course.
  std::vector<MatrixXd> responses_to(BudgetMethod method) const {
    std::vector<MatrixXd> responses;
    for (const Course& course : courses_) {
      responses.push_back(report::LoopResponse(course.loop(method)).follow(course.inputs));
    }
    return responses;
  }

  VectorXd sum_of(const std::vector<MatrixXd>& responses, Index output) const {
    VectorXd sum = VectorXd::Zero(n());
    for (const MatrixXd& response : responses) sum += response.col(output);
    return sum;
  }

  SignalBudget budget_of(const std::vector<MatrixXd>& responses, Index output,
                         BudgetMethod method) {
    const double rate = design_.gains.sample_rate_hz;
    const VectorXd sum = sum_of(responses, output);
    const Levels courses = levels_of(sum, rate, edges_hz_);
    SignalBudget budget{.sources = {}, .total = part_of(courses), .vibration_class = {}};
    for (const MatrixXd& response : responses) {
      const Levels alone = levels_of(response.col(output), rate, edges_hz_);
      BudgetPart part = part_of(alone);
      if (responses.size() > 1) {
        // Of the powers of x, y and x + y, what is between x and y.
        const Levels both = levels_of(response.col(output) + sum, rate, edges_hz_);
        part.shared = (both.power - alone.power - courses.power) / 2;
        part.share = (both.mean_square - alone.mean_square - courses.mean_square) / 2;
      }
      budget.sources.push_back(std::move(part));
    }
    for (const Noise& noise : noises_) add(noise, output, method, budget);
    finish(courses, budget);
    done();
    return budget;
  }

  static void add(const Noise& noise, Index output, BudgetMethod method, SignalBudget& budget) {
    const bool acts =
        noise.feed_forward ? method == BudgetMethod::feed_forward : method != BudgetMethod::passive;
    Levels levels = levels_of(noise.power, output, acts ? noise.mean_square(output) : 0);
    budget.sources.push_back(part_of(levels));
    BudgetPart& total = budget.total;
    total.share += levels.mean_square;
    total.power += levels.power;
    total.velocity = (total.velocity.cwiseAbs2() + levels.velocity.cwiseAbs2()).cwiseSqrt();
  }

  void finish(const Levels& courses, SignalBudget& budget) const {
    BudgetPart& total = budget.total;
    total.rms = std::sqrt(total.share);
    total.shared = total.power;
    budget.vibration_class = report::vibration_class(total.velocity);
    if (!(total.rms > 0)) return;
    // Of the mean square: (S_v^2 + 2 S_d S_v) / T over frequency, v all noises, d the courses.
    const VectorXd width =
        edges_hz_.tail(edges_hz_.size() - 1) - edges_hz_.head(total.power.size());
    const VectorXd by_noise = (total.power - courses.power).cwiseMax(0);
    const double duration_s = static_cast<double>(n()) * T_;
    const double variance =
        (by_noise.array() * (by_noise + 2 * courses.power.cwiseMax(0)).array() / width.array())
            .sum() /
        duration_s;
    budget.scatter = std::sqrt(variance) / (2 * total.rms);
  }

  std::vector<SignalBudget> floors_of(const std::vector<MatrixXd>& responses) {
    std::vector<SignalBudget> floors;
    Index output = std::ssize(plan_.axes);
    for (const ComparedFrame& axis : plan_.axes) {
      SignalBudget& floor = floors.emplace_back();
      if (axis.floor.empty()) continue;
      const Levels levels =
          levels_of(sum_of(responses, output), design_.gains.sample_rate_hz, edges_hz_);
      floor.total = part_of(levels);
      finish(levels, floor);
      ++output;
      done();
    }
    return floors;
  }

  std::string left_out() const {
    const Instruments& instruments = design_.gains.instruments;
    std::string what;
    const auto add = [&what](bool there, const char* name) {
      if (there) what += (what.empty() ? "" : ", ") + std::string(name);
    };
    add(instruments.hysteresis.has_value(), "hysteresis");
    add(std::isfinite(instruments.force_rate_limit), "force_rate_limit_n_per_s");
    add(instruments.force_sensors && std::isfinite(instruments.force_sensors->range),
        "force_sensors.range_n");
    add(design_.gains.force_limit_n.has_value(), "force_limit_n");
    return what;
  }

  void done() {
    ++n_done_;
    if (plan_.progress)
      plan_.progress(static_cast<double>(n_done_) / static_cast<double>(n_to_do_));
  }

  const LoopDesign& design_;
  const BudgetPlan& plan_;
  double T_;
  std::vector<std::string> outputs_;  ///< the frames of the axes, then their floors
  std::optional<BudgetLoops> loops_;
  VectorXd edges_hz_;
  std::vector<Course> courses_;
  std::vector<Noise> noises_;
  Index n_done_ = 0, n_to_do_ = 1;
};

}  // namespace

Budget error_budget(const LoopDesign& design, const floor::FloorSpec& floor,
                    const BudgetPlan& plan) {
  return Maker(design, floor, plan).make();
}

}  // namespace stillframe::judge
