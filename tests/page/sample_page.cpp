#include "tests/page/sample_page.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "report/page/html.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"
#include "tests/page/envelope_of.hpp"

namespace stillframe::test {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double modes_hz[] = {13.9055, 13.9055, 20.0055, 31.3203, 31.3203, 49.0032};
constexpr int n_modes = 6;
constexpr double target_hz = 5, target_damping = 0.7, rate_hz = 1000;

/// |T| of one mode without damping, and of the frame that the gains aim at.
double open_value(double f, int mode) {
  const double ratio = f / modes_hz[mode];
  return 1 / std::max(std::abs(1 - ratio * ratio), 1e-3);
}
double target_value(double f) {
  const std::complex<double> s(0, f / target_hz);
  return std::abs(1.0 / (s * s + 2 * target_damping * s + 1.0));
}
/// The sampled loop leaves the target where its delay tells.
double closed_value(double f, int mode) {
  return target_value(f) * (1 + 0.25 * (mode + 1) * f * f / (f * f + 150 * 150));
}

std::vector<double> logarithmic(double low, double high, int n) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(low * std::pow(high / low, double(i) / (n - 1)));
  return values;
}

template <class Value>
MatrixXd sorted_table(const std::vector<double>& f, Value value) {
  MatrixXd table(static_cast<Index>(f.size()), n_modes);
  for (Index i = 0; i < table.rows(); ++i) {
    for (int m = 0; m < n_modes; ++m) table(i, m) = value(f[static_cast<std::size_t>(i)], m);
    std::sort(table.row(i).begin(), table.row(i).end(), std::greater<>());
  }
  return table;
}

page::MeasuredValues measured(const std::vector<double>& f, const MatrixXd& exact,
                              std::mt19937& generator) {
  std::normal_distribution<double> noise(0, 1);
  page::MeasuredValues result;
  result.frequencies_hz = f;
  result.values = result.lower = result.upper = result.difference_db = exact;
  for (Index i = 0; i < exact.rows(); ++i) {
    const double sigma = 0.003 + 0.02 * std::pow(f[static_cast<std::size_t>(i)] / 200, 2);
    for (Index j = 0; j < exact.cols(); ++j) {
      const double value = exact(i, j) * (1 + sigma * noise(generator));
      result.values(i, j) = value;
      result.lower(i, j) = value * (1 - 2 * sigma);
      result.upper(i, j) = value * (1 + 2 * sigma);
      result.difference_db(i, j) = 20 * std::log10(value / exact(i, j));
    }
    result.coherence.push_back(1 / (1 + sigma * sigma));
  }
  return result;
}

page::SingularValueFigure singular_values(std::mt19937& generator) {
  page::SingularValueFigure figure;
  figure.frequencies_hz = logarithmic(0.5, 200, 600);
  figure.open = sorted_table(figure.frequencies_hz, open_value);
  figure.closed = sorted_table(figure.frequencies_hz, closed_value);
  figure.closed_continuous = sorted_table(figure.frequencies_hz, [](double f, int mode) {
    return target_value(f) * (1 + 1e-3 * mode);
  });
  for (const double f : figure.frequencies_hz) figure.target.push_back(target_value(f));
  const auto lines = logarithmic(0.9, 180, 50);
  figure.open_measured = measured(lines, sorted_table(lines, open_value), generator);
  figure.closed_measured = measured(lines, sorted_table(lines, closed_value), generator);
  // What noise may leave of a value: nothing, or no more than how large it can be.
  page::MeasuredValues& noisy = figure.closed_measured;
  noisy.lower(0, n_modes - 1) = noisy.lower(1, n_modes - 1) = 0;
  noisy.upper(0, n_modes - 1) = HUGE_VAL;
  noisy.difference_db(0, n_modes - 1) = std::nan("");
  figure.allowed_db = 0.1;
  return figure;
}

page::TransmissibilityAxis transmissibility(const std::string& axis, int mode,
                                            std::mt19937& generator) {
  page::TransmissibilityAxis result;
  result.axis = axis;
  result.frequencies_hz = logarithmic(0.5, 200, 400);
  const auto lines = logarithmic(0.9, 180, 40);
  MatrixXd open(40, 1), closed(40, 1);
  for (const double f : result.frequencies_hz) {
    result.passive.push_back(open_value(f, mode));
    result.active.push_back(closed_value(f, mode));
  }
  for (Index i = 0; i < 40; ++i) {
    open(i) = open_value(lines[static_cast<std::size_t>(i)], mode);
    closed(i) = closed_value(lines[static_cast<std::size_t>(i)], mode);
  }
  result.passive_measured = measured(lines, open, generator);
  result.active_measured = measured(lines, closed, generator);
  return result;
}

page::ModeShapes mode_shapes() {
  page::ModeShapes shapes;
  shapes.nodes.push_back({"lens", Vector3d::Zero(), false, 750});
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * std::numbers::pi * i / 3;
    const Vector3d radial(std::cos(angle), std::sin(angle), 0), tangent(-radial.y(), radial.x(), 0);
    const Vector3d mount = 0.6 * radial - Vector3d(0, 0, 0.1);
    const std::string number = std::to_string(i + 1);
    const std::size_t first = shapes.nodes.size();
    shapes.nodes.push_back({"mount_" + number, mount, false, 0});
    shapes.nodes.push_back({"floor_" + number + "t", mount - 0.15 * tangent, true, 0});
    shapes.nodes.push_back({"floor_" + number + "v", mount - Vector3d(0, 0, 0.15), true, 0});
    shapes.elements.push_back({"arm_" + number, page::ShapeKind::rigid, 0, first});
    shapes.elements.push_back({"leg_" + number + "t", page::ShapeKind::truss, first + 1, first});
    shapes.elements.push_back({"leg_" + number + "v", page::ShapeKind::truss, first + 2, first});
  }
  // A camera on a mast, far from the middle of all nodes, whose top moves more than the frame.
  const std::size_t camera = shapes.nodes.size();
  shapes.nodes.push_back({"camera", Vector3d(0.3, 0, 1), false, 2});
  shapes.elements.push_back({"mast", page::ShapeKind::beam, 0, camera});
  // Slides with tilt, turns about the vertical, and so on: rigid motion t + r x position.
  const Vector3d t[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.12, 0, 0}, {0, 0.12, 0}, {0, 0, 0}};
  const Vector3d r[] = {{0, 0.3, 0}, {-0.3, 0, 0}, {0, 0, 0}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  for (int m = 0; m < n_modes; ++m) {
    page::ModeShape mode;
    mode.frequency_hz = modes_hz[m];
    mode.displacement.setZero(static_cast<Index>(shapes.nodes.size()), 3);
    for (std::size_t i = 0; i < shapes.nodes.size(); ++i) {
      if (shapes.nodes[i].floor) continue;
      mode.displacement.row(static_cast<Index>(i)) = t[m] + r[m].cross(shapes.nodes[i].position);
    }
    mode.displacement.row(static_cast<Index>(camera)) *= 1.5;
    shapes.modes.push_back(mode);
  }
  return shapes;
}

/// Noise through a resonance, with a slow swell and one shock.
VectorXd vibration(double duration_s, double rms, double resonance_hz, double damping,
                   std::mt19937& generator) {
  std::normal_distribution<double> noise(0, 1);
  const double omega = 2 * std::numbers::pi * resonance_hz / rate_hz;
  const double radius = std::exp(-damping * omega);
  const auto n = static_cast<Index>(duration_s * rate_hz);
  VectorXd x(n);
  double before = 0, last = 0;
  for (Index i = 0; i < n; ++i) {
    const double swell = 1 + 0.4 * std::sin(2 * std::numbers::pi * double(i) / double(n) * 3);
    const double shock = i == (2 * n) / 3 ? 40 : 0;
    const double next = 2 * radius * std::cos(omega) * last - radius * radius * before +
                        swell * noise(generator) + shock;
    before = last;
    x(i) = last = next;
  }
  return x * (rms / std::sqrt(x.squaredNorm() / double(n)));
}

struct Motion {
  VectorXd floor, passive, active;
};

Motion motion(double duration_s, int axis, std::mt19937& generator) {
  return {vibration(duration_s, 1.0e-3, 11 + axis, 0.4, generator),
          vibration(duration_s, 2.3e-2, modes_hz[axis], 0.004, generator),
          vibration(duration_s, 1.2e-4, 3, 0.6, generator)};
}

page::HistoryAxis history(const std::string& axis, const Motion& motion) {
  page::HistoryAxis result;
  result.axis = axis;
  result.floor = page::envelope_of(motion.floor, rate_hz);
  result.passive = page::envelope_of(motion.passive, rate_hz);
  result.active = page::envelope_of(motion.active, rate_hz);
  return result;
}

report::Psd spectrum(const VectorXd& x) {
  return report::welch(x, rate_hz, report::default_segment_length(x.size(), rate_hz));
}

std::vector<double> list(const VectorXd& values) { return {values.begin(), values.end()}; }

page::Curve octave_curve(const VectorXd& x) {
  page::Curve curve;
  for (const auto& band : report::third_octave_bands()) {
    curve.frequencies_hz.push_back(band.nominal_hz);
  }
  curve.values = list(report::third_octave_velocity(spectrum(x)));
  return curve;
}

page::Curve density_curve(const VectorXd& x, bool cumulative) {
  const report::Psd psd = spectrum(x);
  page::Curve curve;
  for (Index k = 0; k < psd.density.size(); ++k)
    curve.frequencies_hz.push_back(psd.frequency_hz(k));
  curve.values = list(cumulative ? report::cumulative_rms(psd) : psd.density);
  return curve;
}

page::SpectraAxis spectra(const std::string& axis, const Motion& m) {
  return {.axis = axis,
          .third_octaves = {octave_curve(m.floor), octave_curve(m.passive), octave_curve(m.active)},
          .density = {density_curve(m.floor, false), density_curve(m.passive, false),
                      density_curve(m.active, false)},
          .cumulative_rms = {density_curve(m.floor, true), density_curve(m.passive, true),
                             density_curve(m.active, true)}};
}

page::Level level(const VectorXd& x) {
  const VectorXd bands = report::third_octave_velocity(spectrum(x));
  Index largest = 0;
  const double band_velocity = bands.maxCoeff(&largest);
  return {.rms_acceleration = std::sqrt(x.squaredNorm() / double(x.size())),
          .peak_acceleration = x.cwiseAbs().maxCoeff(),
          .band_velocity = band_velocity,
          .band_hz = report::third_octave_bands()[static_cast<std::size_t>(largest)].nominal_hz,
          .vibration_class = report::vibration_class(bands)};
}

page::Histogram histogram(const std::string& name, double centre_us, std::mt19937& generator) {
  page::Histogram result{.name = name, .edges_us = {}, .counts = std::vector<std::int64_t>(60)};
  for (int i = 0; i <= 60; ++i) result.edges_us.push_back(4.0 * i);
  std::lognormal_distribution<double> duration(std::log(centre_us), 0.25);
  for (int i = 0; i < 60000; ++i) {
    const auto bin = static_cast<std::size_t>(duration(generator) / 4);
    ++result.counts[std::min<std::size_t>(bin, 59)];
  }
  return result;
}

std::vector<page::Curve> criteria() {
  std::vector<page::Curve> list;
  for (const auto& criterion : report::vibration_criteria()) {
    page::Curve curve{.name = criterion.name, .frequencies_hz = {}, .values = {}};
    for (const auto& band : report::third_octave_bands()) {
      if (!criterion.applies(band.centre_hz)) continue;
      curve.frequencies_hz.push_back(band.nominal_hz);
      curve.values.push_back(criterion.limit(band.centre_hz));
    }
    list.push_back(curve);
  }
  return list;
}

/// Not Peterson's numbers, but lines where his lie.
std::vector<page::Curve> noise_models() {
  return {{"NLNM", {0.1, 1, 10, 100}, {1e-17, 2e-17, 6e-14, 6e-12}},
          {"NHNM", {0.1, 1, 10, 100}, {3e-11, 2e-10, 3e-8, 3e-6}}};
}

page::Head sample_head() {
  return {.title = "Metrology frame on six piezo legs",
          .program_version = "0.1.0",
          .scene_name = "metrology_frame.yaml",
          .scene_hash = "5f2c9a0e",
          .mode = "lock step over LCM",
          .date = "21 November 2026, 18:36 UTC",
          .loops = {"passive", "active"},
          .sample_rate_hz = 1000,
          .duration_s = 60,
          .delay_samples = 1,
          .outcome = report::Outcome::passed,
          .reasons =
              {"Measured singular values lie within 0.10 dB of the prediction at 50 frequencies.",
               "No sample was lost, and nothing in the logs is damaged."},
          .headlines = {"With the loop closed the frame moves 190 times less than without it and 8 "
                        "times less than the floor; its worst direction, y, meets VC-E."}};
}

page::MatrixTable gain(const std::string& name, const std::string& unit, double size) {
  page::MatrixTable matrix{.name = name, .unit = unit, .rows = {}, .columns = {}, .values = {}};
  for (const char* leg : {"leg_1t", "leg_1v", "leg_2t", "leg_2v", "leg_3t", "leg_3v"}) {
    matrix.rows.emplace_back(leg);
  }
  matrix.columns = matrix.rows;
  matrix.values = MatrixXd::Constant(6, 6, -0.21 * size);
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < 6; ++j) {
      if ((i + j) % 2 == 1) matrix.values(i, j) = 0.06 * size * double(i - j);
    }
    matrix.values(i, i) = size;
  }
  return matrix;
}

void add_tables(page::PageData& data) {
  data.shock = {{"After the floor steps by 1 \u00b5m at 40 s",
                 {"axis", "loop", "peak mm/s\u00b2", "settled within 5 % after s"},
                 {{"x", "passive", "92.4", "\u2013"}, {"x", "active", "0.83", "0.21"}}}};
  data.noise = {{"Acceleration of the frame that the floor does not explain (1 to 100 Hz)",
                 {"axis", "loop", "floor part mm/s\u00b2", "rest mm/s\u00b2", "share of rest"},
                 {{"x", "active", "0.0941", "0.00120", "1.3 %"},
                  {"y", "active", "0.1090", "0.00119", "1.1 %"},
                  {"z", "active", "0.1780", "0.00230", "1.3 %"}}}};
  page::Table effort{"", {"leg", "rms N", "peak N", "share of limit"}, {}};
  for (const char* leg : {"leg_1t", "leg_1v", "leg_2t", "leg_2v", "leg_3t", "leg_3v"}) {
    effort.rows.push_back({leg, "0.812", "4.31", "4.3 %"});
  }
  data.effort = {effort};
  data.timing = {{"",
                  {"loop", "source", "periods", "late", "lost", "duplicates",
                   "worst wake-up \u00b5s", "worst compute \u00b5s"},
                  {{"passive", "plant", "60000", "0", "0", "0", "141", "38.2"},
                   {"active", "plant", "60000", "0", "0", "0", "166", "41.0"},
                   {"active", "controller", "59999", "0", "0", "0", "187", "30.4"}}}};
  data.log = {{"",
               {"log", "samples", "gaps", "damaged places", "unread bytes", "foreign channels"},
               {{"passive.lcm", "60000", "0", "0", "0", "none"},
                {"active.lcm", "60000", "0", "0", "0", "CAMERA_FRAMES (1200)"}}}};
  data.gains = {gain("K_P", "", 95.3), gain("K_I", "1/s", 4192)};
  data.texts = {{"Scene",
                 "# A frame\ntitle: Metrology frame on six piezo legs\nnodes:\n  lens: "
                 "{position: [0, 0, 0]}\n"},
                {"Floor", "recording: vc_d.csv\nscale: 8.9\n"}};
}

}  // namespace

page::PageData sample_page(double duration_s) {
  std::mt19937 generator(7);
  page::PageData data;
  data.head = sample_head();
  data.warnings = {
      {page::Severity::note, "The log holds 1200 messages of a channel that is not ours."},
      {page::Severity::warning,
       "The recommended rate for this target is 2 kHz; at 1 kHz the roll-off costs 3 dB at 100 "
       "Hz."}};
  data.singular_values = singular_values(generator);
  data.modes = mode_shapes();
  const char* names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const Motion m = motion(duration_s, axis, generator);
    data.result.push_back({names[axis], level(m.floor), level(m.passive), level(m.active)});
    data.transmissibility.push_back(transmissibility(names[axis], axis, generator));
    data.histories.push_back(history(names[axis], m));
    data.spectra.axes.push_back(spectra(names[axis], m));
  }
  for (const char* leg : {"leg_1t", "leg_1v"}) {
    data.fit.push_back(transmissibility(leg, static_cast<int>(data.fit.size()), generator));
    data.fit.back().passive_measured = {};
  }
  data.spectra.criteria = criteria();
  data.spectra.models = noise_models();
  for (const char* leg : {"leg_1t", "leg_1v", "leg_2t", "leg_2v", "leg_3t", "leg_3v"}) {
    const VectorXd force = vibration(duration_s, 0.8, 6, 0.5, generator);
    data.leg_forces.push_back({leg, page::envelope_of(force, rate_hz), 8.0});
  }
  data.histograms = {histogram("Controller, active: wake-up", 62, generator),
                     histogram("Controller, active: compute", 14, generator)};
  add_tables(data);
  return data;
}

page::PageData hostile_page() {
  page::PageData data = sample_page(2);
  const std::string name = hostile_name;
  data.head = {.title = name,
               .program_version = name,
               .scene_name = name,
               .scene_hash = name,
               .mode = name,
               .date = name,
               .loops = {name},
               .sample_rate_hz = std::nan(""),
               .duration_s = HUGE_VAL,
               .delay_samples = {},
               .outcome = report::Outcome::failed,
               .reasons = {name},
               .headlines = {name, std::string("not UTF-8 \xff\xc0\xaf, NUL \0.", 21)}};
  data.warnings = {{page::Severity::severe, name}};
  for (auto& axis : data.result) axis.axis = axis.active->vibration_class = name;
  data.singular_values->quantity = name;
  data.singular_values->open(3, 0) = std::nan("");
  data.singular_values->closed_measured.values(2, 1) = HUGE_VAL;
  for (auto& axis : data.transmissibility) axis.axis = name;
  for (auto& leg : data.fit) leg.axis = name;
  for (auto& node : data.modes->nodes) node.name = name;
  for (auto& element : data.modes->elements) element.name = name;
  for (auto& axis : data.histories) axis.axis = axis.unit = name;
  for (auto& leg : data.leg_forces) leg.leg = name;
  for (auto& axis : data.spectra.axes) axis.axis = name;
  for (auto& curve : data.spectra.criteria) curve.name = name;
  for (auto& histogram : data.histograms) histogram.name = name;
  for (auto& table : data.timing) {
    table.caption = name;
    for (auto& column : table.columns) column = name;
    for (auto& row : table.rows) row.assign(row.size(), name);
  }
  for (auto& matrix : data.gains) matrix.name = matrix.unit = matrix.rows[0] = name;
  for (auto& text : data.texts) text.name = text.text = name;
  return data;
}

}  // namespace stillframe::test
