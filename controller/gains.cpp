#include "controller/gains.hpp"

#include <cmath>
#include <set>

#include "controller/law_block.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/yaml/instruments_block.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "core/yaml/ranges.hpp"

namespace stillframe::controller {

using Eigen::Index;

namespace {

std::vector<std::string> read_legs(const YamlReader& reader) {
  std::vector<std::string> legs;
  std::set<std::string> seen;
  for (const YamlReader& item : reader.items()) {
    const std::string leg = item.text();
    if (!seen.insert(leg).second) item.fail("found \"" + leg + "\" twice, leg names are unique");
    legs.push_back(leg);
  }
  if (legs.empty() || static_cast<Index>(legs.size()) > largest_loop) {
    reader.fail("found " + std::to_string(legs.size()) + " names, allowed are 1 to " +
                std::to_string(largest_loop));
  }
  return legs;
}

Realisation read_realisation(const YamlReader& reader) {
  const auto implicit = to_text(Realisation::implicit_feedthrough);
  const auto naive = to_text(Realisation::naive_pi);
  return reader.one_of({implicit, naive}) == implicit ? Realisation::implicit_feedthrough
                                                      : Realisation::naive_pi;
}

Eigen::MatrixXd read_matrix(const YamlReader& reader, Index rows, Index cols) {
  return reader.matrix(rows, cols, largest_entry);
}

PassivePlant read_plant(const YamlReader& reader, Index n_legs) {
  reader.allow_only({"hash", "A", "B", "C", "B_w", "A_w", "C_w"});
  const YamlReader A = reader.require("A");
  const auto n = static_cast<Index>(A.items().size());
  if (n == 0) A.fail("found no rows, the plant has one state or more");
  if (n > largest_loop) {
    A.fail("found " + std::to_string(n) + " rows, allowed are up to " +
           std::to_string(largest_loop));
  }
  PassivePlant plant{.A = read_matrix(A, n, n),
                     .B = read_matrix(reader.require("B"), n, n_legs),
                     .C = read_matrix(reader.require("C"), n_legs, n),
                     .B_w = Eigen::MatrixXd::Zero(n, 0)};
  if (const auto floor = reader.find("B_w")) {
    const auto rows = floor->items();
    if (rows.empty()) floor->fail("found no rows, allowed is one for each state");
    const auto p = static_cast<Index>(rows.front().items().size());
    if (p > most_floor_channels) {
      floor->fail("found " + std::to_string(p) + " columns, allowed are up to " +
                  std::to_string(most_floor_channels));
    }
    plant.B_w = read_matrix(*floor, n, p);
  }
  const auto A_w = reader.find("A_w"), C_w = reader.find("C_w");
  if (!A_w && !C_w) return plant;
  if (plant.B_w.cols() == 0) reader.require("B_w");
  plant.A_w = read_matrix(reader.require("A_w"), n, 2 * plant.B_w.cols());
  plant.C_w = read_matrix(reader.require("C_w"), n_legs, 2 * plant.B_w.cols());
  return plant;
}

std::vector<std::string> read_floor_names(const YamlReader& floor, Index p) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const YamlReader& item : floor.items()) {
    names.push_back(item.text());
    if (!seen.insert(item.text()).second) item.fail("found \"" + item.text() + "\" twice");
  }
  if (names.empty() || std::ssize(names) != p) {
    floor.fail("found " + std::to_string(names.size()) +
               " names, allowed is one for each acceleration of the floor that plant: B_w has, " +
               std::to_string(p) + ", and one at least");
  }
  return names;
}

FloorFeedForward read_feed_forward(const YamlReader& reader, const Gains& gains) {
  reader.allow_only({"floor", "memory", "taps", "weights"});
  const Index p = gains.plant.B_w.cols();
  FloorFeedForward found;
  found.floor = read_floor_names(reader.require("floor"), p);
  const YamlReader memory = reader.require("memory");
  found.filter.memory = number_within(memory, 0, 1);
  if (found.filter.memory == 1) memory.fail("found 1, allowed is 0 to below 1");
  const YamlReader taps = reader.require("taps");
  const int n_taps = taps.integer(2);
  if (n_taps > most_taps) {
    taps.fail("found " + taps.text() + ", allowed are 2 to " + std::to_string(most_taps));
  }
  found.filter.n_taps = n_taps;
  found.filter.weights =
      read_matrix(reader.require("weights"), gains.n_legs(), p * found.filter.n_terms());
  return found;
}

BroughtLaw read_brought_law(const YamlReader& reader, const Gains& gains) {
  reader.allow_only({"floor", "inputs", "outputs", "A", "B", "C", "D"});
  BroughtLaw found{.matrices = read_law_block(reader)};
  if (const auto floor = reader.find("floor")) {
    found.floor = read_floor_names(*floor, gains.plant.B_w.cols());
  }
  try {
    own_law(found.matrices, gains.legs, found.floor);
  } catch (const InputError& error) {
    reader.fail(error.what());
  }
  return found;
}

/// What a design wrote into the file it knows again: a plant that was changed since by hand, disk
/// or wire would judge another loop than the one that runs. Whether there is a hash.
bool check_plant_hash(const YamlReader& plant, const Gains& gains) {
  const auto written = plant.find("hash");
  if (!written) return false;
  const std::string found = plant_hash(gains);
  if (written->text() == found) return true;
  written->fail("found " + written->text() +
                ", but legs, scene_hash and the matrices that stand here have " + found +
                ": they are not those that were designed. `stillframe design --out` writes "
                "them anew; a plant that is meant to be another one has no hash");
}

Gains read(const YamlReader& reader) {
  if (!reader.find("stillframe_gains")) {
    reader.fail(
        "no gains file: the key 'stillframe_gains' is missing; `stillframe design SCENE --out "
        "FILE` "
        "makes one of a scene");
  }
  const YamlReader version = reader.require("stillframe_gains");
  if (version.integer(1) != 1) version.fail("found " + version.text() + ", allowed is 1");
  reader.allow_only({"stillframe_gains", "scene_hash", "legs", "sample_rate_hz", "delay_samples",
                     "target_hz", "realisation", "leak_hz", "high_pass_hz", "lead_samples",
                     "roll_off_hz", "force_limit_n", "instruments", "K_P", "K_I", "plant",
                     "feed_forward", "law"});
  Gains gains;
  gains.scene_hash = reader.require("scene_hash").text();
  gains.legs = read_legs(reader.require("legs"));
  gains.sample_rate_hz =
      number_within(reader.require("sample_rate_hz"), lowest_rate_hz, highest_rate_hz);
  gains.delay_samples = number_within(reader.require("delay_samples"), 0, longest_delay_samples);
  if (const auto targets = reader.find("target_hz")) {
    for (const YamlReader& target : targets->items()) {
      gains.target_hz.push_back(positive_up_to(target, highest_hz));
    }
  }
  gains.realisation = read_realisation(reader.require("realisation"));
  gains.leak_hz = number_within(reader.require("leak_hz"), 0, highest_hz);
  if (const auto corner = reader.find("high_pass_hz")) {
    gains.high_pass_hz = number_within(*corner, 0, highest_hz);
  }
  if (const auto lead = reader.find("lead_samples")) {
    gains.lead_samples = number_within(*lead, 0, longest_lead_samples);
  }
  if (const auto corner = reader.find("roll_off_hz")) {
    gains.roll_off_hz = positive_up_to(*corner, highest_hz);
  }
  if (const auto limit = reader.find("force_limit_n")) {
    gains.force_limit_n = positive_up_to(*limit, largest_force_n);
  }
  if (const auto block = reader.find("instruments")) gains.instruments = read_instruments(*block);
  gains.K_P = read_matrix(reader.require("K_P"), gains.n_legs(), gains.n_legs());
  gains.K_I = read_matrix(reader.require("K_I"), gains.n_legs(), gains.n_legs());
  const YamlReader plant = reader.require("plant");
  gains.plant = read_plant(plant, gains.n_legs());
  gains.plant_is_as_designed = check_plant_hash(plant, gains);
  if (const auto block = reader.find("feed_forward")) {
    gains.feed_forward = read_feed_forward(*block, gains);
  }
  if (const auto block = reader.find("law")) {
    gains.law = read_brought_law(*block, gains);
    if (!gains.feed_forward.filter.empty() && !gains.law->floor.empty()) {
      block->fail("allowed is either feed_forward or a law that hears the floor itself");
    }
  }
  if (most_loop_states(gains) > largest_loop) {
    reader.fail("found a loop of " + std::to_string(most_loop_states(gains)) +
                " states (plant, law, and what is under way by delay_samples and "
                "report_age_samples), allowed are up to " +
                std::to_string(largest_loop));
  }
  return gains;
}

}  // namespace

std::string_view to_text(Realisation realisation) {
  return realisation == Realisation::implicit_feedthrough ? "implicit_feedthrough" : "naive_pi";
}

Index most_loop_states(const Gains& gains) {
  // Of each leg: lag and filter, the law with leak, high-pass, roll-off and lead, the force that is
  // held, the filtered report, and what is under way.
  const double per_leg = 8 + std::ceil(gains.delay_samples) + gains.instruments.report_age_samples;
  const Index own = gains.law ? gains.law->matrices.A.rows() : 0;
  return gains.plant.A.rows() + own + gains.n_legs() * static_cast<Index>(per_leg);
}

const std::vector<std::string>& Gains::heard_floor() const {
  return feed_forward.filter.empty() && law ? law->floor : feed_forward.floor;
}

void Gains::forget_floor() {
  feed_forward = {};
  if (law) law = BroughtLaw{.matrices = without_floor(law->matrices)};
}

ForceFeedback Gains::feedback() const {
  return {.K_P = K_P,
          .K_I = K_I,
          .leak = two_pi * leak_hz,
          .high_pass = two_pi * high_pass_hz,
          .roll_off = two_pi * roll_off_hz.value_or(0.0)};
}

LawSampling Gains::law_sampling() const {
  return {.realisation = realisation,
          .sample_time = sample_time(),
          .lead_samples = lead_samples,
          .sensor_filter_hz = instruments.sensor_filter_hz};
}

Sampling Gains::sampling() const {
  return {.sample_time = sample_time(),
          .delay_samples = delay_samples,
          .instruments = instruments,
          .leg_gains = {},
          .leg_delays = {}};
}

LoopPlant Gains::feedback_plant() const {
  const Index n = plant.A.rows();
  return {.A = plant.A,
          .B_w = Eigen::MatrixXd::Zero(n, 0),
          .B_u = plant.B,
          .C_y = Eigen::MatrixXd::Zero(0, n),
          .D_yw = Eigen::MatrixXd::Zero(0, 0),
          .D_yu = Eigen::MatrixXd::Zero(0, n_legs()),
          .C_sigma = plant.C};
}

LoopPlant Gains::loop_plant(double corner) const {
  LoopPlant with_floor = feedback_plant();
  const Index n = plant.A.rows(), p = plant.B_w.cols(), n_floor = plant.A_w.cols();
  with_floor.B_w = plant.B_w;
  if (n_floor > 0) {
    const Index total = n + n_floor;
    const auto grow = [](Eigen::MatrixXd& M, Index rows, Index cols) {
      M.conservativeResizeLike(Eigen::MatrixXd::Zero(rows, cols));
    };
    grow(with_floor.A, total, total);
    grow(with_floor.B_u, total, n_legs());
    grow(with_floor.B_w, total, p);
    with_floor.C_sigma.conservativeResize(n_legs(), total);
    with_floor.A.topRightCorner(n, n_floor) = plant.A_w;
    with_floor.A.diagonal().tail(n_floor).setConstant(-corner);
    with_floor.A.block(n + p, n, p, p).setIdentity();
    with_floor.B_w.middleRows(n, p).setIdentity();
    with_floor.C_sigma.rightCols(n_floor) = plant.C_w;
    with_floor.n_exogenous = n_floor;
  }
  with_floor.C_y = with_floor.C_sigma;
  with_floor.D_yw = Eigen::MatrixXd::Zero(n_legs(), p);
  with_floor.D_yu = Eigen::MatrixXd::Identity(n_legs(), n_legs());
  return with_floor;
}

Gains read_gains(const std::filesystem::path& path) { return read(YamlReader::from_file(path)); }

Gains parse_gains(const std::string& text, const std::string& source_name) {
  return read(YamlReader::from_text(text, source_name));
}

}  // namespace stillframe::controller
