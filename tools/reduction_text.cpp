#include "tools/reduction_text.hpp"

#include <cmath>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"
#include "report/table.hpp"

namespace stillframe::tools {

using Eigen::Index;

namespace {

/// What a reduced model is off by at most, over the band that it is for.
struct Bounds {
  explicit Bounds(const ReducedModel& reduced)
      : frequencies_hz(logarithmic_frequencies(reduced.to_hz / 100, reduced.to_hz, 9)),
        at_most(bounds_of(reduced, frequencies_hz)),
        largest(frequencies_hz.size()) {
    for (Index i = 0; i < frequencies_hz.size(); ++i) {
      const double omega = two_pi * frequencies_hz(i);
      const Eigen::MatrixXcd G = transfer_function(reduced.linear, {0, omega});
      largest(i) =
          singular_values(Eigen::MatrixXcd(G.topLeftCorner(reduced.n_out, reduced.n_in)))(0);
    }
  }
  Eigen::VectorXd frequencies_hz, at_most, largest;
};

std::optional<Bounds> bounds_of(const ReducedModel& reduced) {
  if (reduced.n_in == 0 || reduced.n_out == 0) return std::nullopt;
  return Bounds(reduced);
}

}  // namespace

Json reduction_json(const ReducedModel& reduced) {
  Json document{{"n_modes", reduced.n_modes},
                {"n_corrections", reduced.n_corrections},
                {"to_hz", reduced.to_hz},
                {"first_left_out_hz", reduced.first_left_out_hz},
                {"bounds", Json::array()}};
  if (const auto bounds = bounds_of(reduced)) {
    for (Index i = 0; i < bounds->at_most.size(); ++i) {
      document["bounds"].push_back({{"hz", bounds->frequencies_hz(i)},
                                    {"at_most", bounds->at_most(i)},
                                    {"largest_singular_value", bounds->largest(i)}});
    }
  }
  return document;
}

std::string reduction_text(const ReducedModel& reduced) {
  std::string text =
      formatted("Reduced: %td modes and %td corrections, for up to %.4g Hz; ", reduced.n_modes,
                reduced.n_corrections, reduced.to_hz) +
      (std::isfinite(reduced.first_left_out_hz)
           ? formatted("the first mode that is left out is at %.4g Hz\n", reduced.first_left_out_hz)
           : std::string("no mode is left out\n"));
  const auto bounds = bounds_of(reduced);
  if (!bounds) return text;
  report::Table table({"Hz", "largest singular value", "of the difference, at most"}, 0);
  for (Index i = 0; i < bounds->at_most.size(); ++i) {
    table.add({formatted("%.4g", bounds->frequencies_hz(i)), formatted("%.4e", bounds->largest(i)),
               formatted("%.1e", bounds->at_most(i))});
  }
  return text + table.print();
}

Eigen::VectorXd bounds_of(const ReducedModel& reduced, const Eigen::VectorXd& frequencies_hz) {
  return frequencies_hz.unaryExpr([&](double hz) { return reduced.bound(two_pi * hz); });
}

}  // namespace stillframe::tools
