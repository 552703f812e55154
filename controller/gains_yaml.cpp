#include <array>
#include <charconv>
#include <cstdint>

#include "controller/gains.hpp"
#include "controller/law_block.hpp"
#include "core/errors/formatted.hpp"
#include "core/yaml/quoted.hpp"

namespace stillframe::controller {

using Eigen::Index;

namespace {

// to_chars, not printf: a gains file is the same under every locale.
std::string digits(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::general, 17);
  return {buffer.data(), end.ptr};
}

std::string rows(const Eigen::MatrixXd& matrix, const std::string& indent) {
  std::string out;
  for (Index i = 0; i < matrix.rows(); ++i) {
    out += indent + "- [";
    for (Index j = 0; j < matrix.cols(); ++j) out += (j ? ", " : "") + digits(matrix(i, j));
    out += "]\n";
  }
  return out;
}

std::string matrix(const std::string& indent, const char* name, const Eigen::MatrixXd& values) {
  return indent + name + (values.rows() == 0 ? ": []\n" : ":\n" + rows(values, indent + "  "));
}

std::string names(const std::vector<std::string>& values) {
  std::string out = "[";
  for (const auto& value : values) out += (out.size() > 1 ? ", " : "") + quoted(value);
  return out + "]";
}

std::string instruments_block(const Instruments& has) {
  if (has.ideal()) return "";
  std::string out = "instruments:\n";
  if (has.actuator_gain != 1) out += "  actuator_gain: " + digits(has.actuator_gain) + "\n";
  if (has.actuator_lag_hz > 0) out += "  actuator_lag_hz: " + digits(has.actuator_lag_hz) + "\n";
  if (has.sensor_filter_hz > 0) {
    out += "  sensor_filter_hz: " + digits(has.sensor_filter_hz) + "\n";
  }
  out += std::string("  applied_force: ") +
         (has.report == Instruments::Report::measured ? "measured" : "commanded") + "\n";
  return out + "  report_age_samples: " + std::to_string(has.report_age_samples) + "\n";
}

}  // namespace

std::string plant_hash(const Gains& gains) {
  std::string text = gains.scene_hash + names(gains.legs);
  for (const Eigen::MatrixXd* M : {&gains.plant.A, &gains.plant.B, &gains.plant.C, &gains.plant.B_w,
                                   &gains.plant.A_w, &gains.plant.C_w}) {
    text += rows(*M, "");
  }
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
  for (const unsigned char byte : text) hash = (hash ^ byte) * 1099511628211ULL;
  return formatted("%016llx", static_cast<unsigned long long>(hash));
}

std::string law_block(const NamedLaw& law, const std::string& indent) {
  return indent + "inputs: " + names(law.inputs) + "\n" + indent +
         "outputs: " + names(law.outputs) + "\n" + matrix(indent, "A", law.A) +
         matrix(indent, "B", law.B) + matrix(indent, "C", law.C) + matrix(indent, "D", law.D);
}

std::string to_yaml(const Gains& gains) {
  std::string out = "stillframe_gains: 1\n";
  out += "scene_hash: " + quoted(gains.scene_hash) + "\n";
  out += "legs: " + names(gains.legs) + "\n";
  out += "sample_rate_hz: " + digits(gains.sample_rate_hz) + "\n";
  out += "delay_samples: " + digits(gains.delay_samples) + "\n";
  if (!gains.target_hz.empty()) {
    std::string list;
    for (const double target : gains.target_hz) list += (list.empty() ? "" : ", ") + digits(target);
    out += "target_hz: [" + list + "]\n";
  }
  out += "realisation: " + std::string(to_text(gains.realisation)) + "\n";
  out += "leak_hz: " + digits(gains.leak_hz) + "\n";
  if (gains.high_pass_hz > 0) out += "high_pass_hz: " + digits(gains.high_pass_hz) + "\n";
  if (gains.lead_samples > 0) out += "lead_samples: " + digits(gains.lead_samples) + "\n";
  if (gains.roll_off_hz) out += "roll_off_hz: " + digits(*gains.roll_off_hz) + "\n";
  if (gains.force_limit_n) out += "force_limit_n: " + digits(*gains.force_limit_n) + "\n";
  out += instruments_block(gains.instruments);
  out += "K_P:\n" + rows(gains.K_P, "  ");
  out += "K_I:\n" + rows(gains.K_I, "  ");
  out += "plant:\n";
  out += "  hash: " + quoted(plant_hash(gains)) + "\n";
  out += "  A:\n" + rows(gains.plant.A, "    ");
  out += "  B:\n" + rows(gains.plant.B, "    ");
  out += "  C:\n" + rows(gains.plant.C, "    ");
  if (gains.plant.B_w.cols() > 0) out += "  B_w:\n" + rows(gains.plant.B_w, "    ");
  if (gains.plant.A_w.cols() > 0) {
    out += "  A_w:\n" + rows(gains.plant.A_w, "    ");
    out += "  C_w:\n" + rows(gains.plant.C_w, "    ");
  }
  if (!gains.feed_forward.filter.empty()) {
    const FeedForward& filter = gains.feed_forward.filter;
    out += "feed_forward:\n  floor: " + names(gains.feed_forward.floor) + "\n";
    out += "  memory: " + digits(filter.memory) + "\n";
    out += "  taps: " + std::to_string(filter.n_taps) + "\n";
    out += "  weights:\n" + rows(filter.weights, "    ");
  }
  if (gains.law) {
    out += "law:\n";
    if (!gains.law->floor.empty()) out += "  floor: " + names(gains.law->floor) + "\n";
    out += law_block(gains.law->matrices, "  ");
  }
  return out;
}

}  // namespace stillframe::controller
