#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

namespace stillframe::page {

/// A signal as smallest and largest value of consecutive parts of equal length: no peak is hidden,
/// however long the signal.
struct Envelope {
  double first_time_s = 0;        ///< s, of the first sample
  double sample_time_s = 0;       ///< s
  std::int64_t part_samples = 1;  ///< samples a part; the last part may hold fewer
  std::int64_t n_samples = 0;
  std::vector<float> lower, upper;  ///< a part each, any unit; NaN where there is no finite sample
  /// The exact smallest and largest finite sample; NaN if there is none.
  double smallest = std::numeric_limits<double>::quiet_NaN();
  double largest = std::numeric_limits<double>::quiet_NaN();

  bool empty() const { return lower.empty(); }
};

/// Makes an envelope of a signal whose length is not known beforehand, in memory that does not
/// grow: where there are most_parts, neighbours are joined, so that it ends with more than half of
/// them. Set-up.
class EnvelopeBuilder {
 public:
  static constexpr std::size_t default_parts = 8192;

  /// sample_time_s: s; first_time_s: s; most_parts: even. Errors: std::invalid_argument for a
  /// sample time that is not positive or parts that are not even and positive.
  EnvelopeBuilder(double sample_time_s, double first_time_s = 0,
                  std::size_t most_parts = default_parts);

  /// The next sample, NaN if it is missing.
  void add(double value);
  void add(const Eigen::Ref<const Eigen::VectorXd>& values);
  /// The next n samples are missing.
  void skip(std::int64_t n);

  Envelope finish() const;

 private:
  void close_part();

  Envelope envelope_;
  std::size_t most_parts_;
  std::int64_t in_part_ = 0;
  double lower_, upper_;  // of the open part
};

/// The same envelope with neighbouring parts joined once: half as many.
Envelope halved(const Envelope& envelope);

/// 16-bit numbers of an envelope: a value is origin + step * code, absent_code is no value.
/// A lower bound is rounded down and an upper bound up, so that the envelope still encloses the
/// signal; where both are one sample, to the nearest. Error: below one step = (largest - smallest)
/// / 65532.
struct QuantisedEnvelope {
  static constexpr std::int16_t absent_code = -32768;
  double origin = 0, step = 0;
  std::vector<std::int16_t> lower, upper;  ///< upper is empty where every part is one sample
};
QuantisedEnvelope quantise(const Envelope& envelope);

}  // namespace stillframe::page
