#include "report/page/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stillframe::page {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double largest_code = 32766;

// std::fmin and std::fmax answer the other value where one is NaN.
void join_neighbours(Envelope& envelope) {
  const std::size_t n = envelope.lower.size(), n_joined = (n + 1) / 2;
  for (std::size_t i = 0; i < n_joined; ++i) {
    const std::size_t first = 2 * i, second = std::min(first + 1, n - 1);
    envelope.lower[i] = std::fmin(envelope.lower[first], envelope.lower[second]);
    envelope.upper[i] = std::fmax(envelope.upper[first], envelope.upper[second]);
  }
  envelope.lower.resize(n_joined);
  envelope.upper.resize(n_joined);
  envelope.part_samples *= 2;
}

float not_above(double value) {
  const float rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity())
                         : rounded;
}

float not_below(double value) { return -not_above(-value); }

}  // namespace

EnvelopeBuilder::EnvelopeBuilder(double sample_time_s, double first_time_s, std::size_t most_parts)
    : most_parts_(most_parts), lower_(nan), upper_(nan) {
  if (!(sample_time_s > 0)) throw std::invalid_argument("envelope: sample time not positive");
  if (most_parts < 2 || most_parts % 2 != 0) {
    throw std::invalid_argument("envelope: the number of parts must be even and positive");
  }
  envelope_.first_time_s = first_time_s;
  envelope_.sample_time_s = sample_time_s;
}

void EnvelopeBuilder::add(double value) {
  if (std::isfinite(value)) {
    lower_ = std::fmin(lower_, value);
    upper_ = std::fmax(upper_, value);
    envelope_.smallest = std::fmin(envelope_.smallest, value);
    envelope_.largest = std::fmax(envelope_.largest, value);
  }
  ++envelope_.n_samples;
  if (++in_part_ == envelope_.part_samples) close_part();
}

void EnvelopeBuilder::add(const Eigen::Ref<const Eigen::VectorXd>& values) {
  for (const double value : values) add(value);
}

void EnvelopeBuilder::skip(std::int64_t n) {
  while (n > 0) {
    const std::int64_t taken = std::min(n, envelope_.part_samples - in_part_);
    in_part_ += taken;
    envelope_.n_samples += taken;
    n -= taken;
    if (in_part_ == envelope_.part_samples) close_part();
  }
}

void EnvelopeBuilder::close_part() {
  // Joined only when one more is to come, so that a signal of most_parts samples keeps them all.
  if (envelope_.lower.size() == most_parts_) {
    join_neighbours(envelope_);
    if (in_part_ < envelope_.part_samples) return;
  }
  envelope_.lower.push_back(not_above(lower_));
  envelope_.upper.push_back(not_below(upper_));
  in_part_ = 0;
  lower_ = upper_ = nan;
}

Envelope EnvelopeBuilder::finish() const {
  EnvelopeBuilder last = *this;
  if (last.in_part_ > 0) last.close_part();
  // A part that is not full stays open if closing it joined the others.
  if (last.in_part_ > 0) {
    last.envelope_.lower.push_back(not_above(last.lower_));
    last.envelope_.upper.push_back(not_below(last.upper_));
  }
  return last.envelope_;
}

Envelope halved(const Envelope& envelope) {
  Envelope half = envelope;
  if (!half.empty()) join_neighbours(half);
  return half;
}

QuantisedEnvelope quantise(const Envelope& envelope) {
  QuantisedEnvelope result;
  const bool any = std::isfinite(envelope.smallest) && std::isfinite(envelope.largest);
  result.origin = any ? (envelope.smallest + envelope.largest) / 2 : 0;
  // In halves, as the difference of two finite numbers need not be finite.
  result.step = any ? (envelope.largest / 2 - envelope.smallest / 2) / largest_code : 0;
  const auto code = [&](float value, double (*round)(double)) -> std::int16_t {
    if (!std::isfinite(value)) return QuantisedEnvelope::absent_code;
    if (!(result.step > 0)) return 0;
    // One code more than the range takes up what rounding to float and outwards may add.
    return static_cast<std::int16_t>(std::clamp(round((value - result.origin) / result.step),
                                                -largest_code - 1, largest_code + 1));
  };
  const bool samples = envelope.part_samples == 1;
  for (std::size_t i = 0; i < envelope.lower.size(); ++i) {
    const auto nearest = [](double x) { return std::round(x); };
    const auto down = [](double x) { return std::floor(x); };
    const auto up = [](double x) { return std::ceil(x); };
    result.lower.push_back(code(envelope.lower[i], samples ? +nearest : +down));
    if (!samples) result.upper.push_back(code(envelope.upper[i], up));
  }
  return result;
}

}  // namespace stillframe::page
