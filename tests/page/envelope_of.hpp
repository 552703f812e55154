#pragma once

#include "report/page/envelope.hpp"

namespace stillframe::page {

/// The envelope of a whole signal, from x (n) at first_time_s, first_time_s + 1 / rate, ...
inline Envelope envelope_of(const Eigen::VectorXd& x, double sample_rate_hz,
                            double first_time_s = 0,
                            std::size_t most_parts = EnvelopeBuilder::default_parts) {
  EnvelopeBuilder builder(1 / sample_rate_hz, first_time_s, most_parts);
  builder.add(x);
  return builder.finish();
}

}  // namespace stillframe::page
