#include "report/page/figures_json.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/input_error.hpp"
#include "report/page/thin_spectrum.hpp"
#include "report/page/write_page.hpp"

namespace stillframe::page {

namespace {

constexpr std::size_t spectrum_steps = 500, cumulative_steps = 300;

void require(bool fits, const std::string& part) {
  if (!fits) throw InputError("report page: sizes do not fit each other in " + part);
}

void require_rows(const Eigen::MatrixXd& matrix, std::size_t n, const std::string& part) {
  require(matrix.size() == 0 || matrix.rows() == static_cast<Eigen::Index>(n), part);
}

Json measured_json(const MeasuredValues& measured, const std::string& part) {
  if (measured.frequencies_hz.empty()) return nullptr;
  const std::size_t n = measured.frequencies_hz.size();
  for (const auto* matrix : {&measured.lower, &measured.upper, &measured.difference_db}) {
    require_rows(*matrix, n, part);
    require(matrix->size() == 0 || matrix->cols() == measured.values.cols(), part);
  }
  require(measured.values.rows() == static_cast<Eigen::Index>(n), part);
  require(measured.lower.size() == measured.upper.size(), part);
  require(measured.coherence.empty() || measured.coherence.size() == n, part);
  Eigen::MatrixXd values = measured.values;
  for (Eigen::Index f = 0; f < values.rows(); ++f) {
    for (Eigen::Index s = 0; s < values.cols(); ++s) {
      if (!measured.is_bounded(f, s)) values(f, s) = std::nan("");
    }
  }
  return {{"f", rounded(measured.frequencies_hz)},
          {"values", columns_of(values)},
          {"lower", columns_of(measured.lower)},
          {"upper", columns_of(measured.upper)},
          {"coherence", rounded(measured.coherence)},
          {"difference_db", columns_of(measured.difference_db)}};
}

Json singular_values_json(const SingularValueFigure& figure) {
  const std::size_t n = figure.frequencies_hz.size();
  for (const auto* curves : {&figure.open, &figure.closed, &figure.closed_continuous}) {
    require_rows(*curves, n, "singular values");
  }
  require(figure.target.empty() || figure.target.size() == n, "singular values: target");
  return {{"quantity", figure.quantity},
          {"f", rounded(figure.frequencies_hz)},
          {"open", columns_of(figure.open)},
          {"closed", columns_of(figure.closed)},
          {"continuous", columns_of(figure.closed_continuous)},
          {"target", rounded(figure.target)},
          {"open_measured", measured_json(figure.open_measured, "open loop as measured")},
          {"closed_measured", measured_json(figure.closed_measured, "closed loop as measured")},
          {"allowed_db", rounded(figure.allowed_db)}};
}

Json transmissibility_json(const std::vector<TransmissibilityAxis>& axes, const std::string& name) {
  Json list = Json::array();
  for (const TransmissibilityAxis& axis : axes) {
    const std::string part = name + " " + axis.axis;
    const std::size_t n = axis.frequencies_hz.size();
    require(axis.passive.empty() || axis.passive.size() == n, part);
    require(axis.active.empty() || axis.active.size() == n, part);
    list.push_back({{"axis", axis.axis},
                    {"f", rounded(axis.frequencies_hz)},
                    {"passive", rounded(axis.passive)},
                    {"active", rounded(axis.active)},
                    {"passive_measured", measured_json(axis.passive_measured, part)},
                    {"active_measured", measured_json(axis.active_measured, part)}});
  }
  return list;
}

Json nodes_json(const ModeShapes& shapes) {
  Json list = Json::array();
  for (const ShapeNode& node : shapes.nodes) {
    list.push_back({{"name", node.name},
                    {"position", rounded(Eigen::VectorXd(node.position))},
                    {"floor", node.floor},
                    {"mass", rounded(node.mass)}});
  }
  return list;
}

Json elements_json(const ModeShapes& shapes) {
  static constexpr const char* kinds[] = {"truss", "beam", "rigid", "hinge"};
  Json list = Json::array();
  for (const ShapeElement& element : shapes.elements) {
    require(std::max(element.node_p, element.node_q) < shapes.nodes.size(),
            "mode shapes: element " + element.name);
    list.push_back({{"name", element.name},
                    {"kind", kinds[static_cast<int>(element.kind)]},
                    {"p", element.node_p},
                    {"q", element.node_q}});
  }
  return list;
}

Json modes_json(const ModeShapes& shapes) {
  Json list = Json::array();
  for (const ModeShape& mode : shapes.modes) {
    require(mode.displacement.rows() == static_cast<Eigen::Index>(shapes.nodes.size()),
            "mode shapes: displacement");
    Json displacement = Json::array();
    for (Eigen::Index i = 0; i < mode.displacement.rows(); ++i) {
      displacement.push_back(rounded(Eigen::VectorXd(mode.displacement.row(i).transpose())));
    }
    list.push_back({{"frequency_hz", rounded(mode.frequency_hz)},
                    {"damping_ratio", mode.damping_ratio ? rounded(*mode.damping_ratio) : Json()},
                    {"displacement", displacement}});
  }
  return {{"nodes", nodes_json(shapes)},
          {"elements", elements_json(shapes)},
          {"modes", list},
          {"planar", shapes.planar}};
}

Json envelope_json(const Envelope& envelope) {
  if (envelope.empty()) return nullptr;
  const QuantisedEnvelope codes = quantise(envelope);
  return {{"first_time_s", rounded(envelope.first_time_s)},
          {"part_s", envelope.sample_time_s * static_cast<double>(envelope.part_samples)},
          {"sample_s", envelope.sample_time_s},
          {"origin", codes.origin},
          {"step", codes.step},
          {"smallest", rounded(envelope.smallest)},
          {"largest", rounded(envelope.largest)},
          {"lower", base64(codes.lower)},
          {"upper", base64(codes.upper)}};
}

/// All histories, halved together until they fit.
class Histories {
 public:
  explicit Histories(const PageData& data) : axes_(data.histories), legs_(data.leg_forces) {
    while (bytes() > most_history_bytes && halve_longest()) {
    }
  }

  Json json() const {
    Json axes = Json::array(), legs = Json::array();
    for (const HistoryAxis& axis : axes_) {
      axes.push_back({{"axis", axis.axis},
                      {"unit", axis.unit},
                      {"floor", envelope_json(axis.floor)},
                      {"passive", envelope_json(axis.passive)},
                      {"active", envelope_json(axis.active)}});
    }
    for (const LegHistory& leg : legs_) {
      legs.push_back({{"leg", leg.leg},
                      {"force", envelope_json(leg.force)},
                      {"limit_n", leg.limit_n ? rounded(*leg.limit_n) : Json()}});
    }
    return {{"axes", axes}, {"legs", legs}};
  }

 private:
  std::vector<Envelope*> all() {
    std::vector<Envelope*> list;
    for (HistoryAxis& axis : axes_) {
      for (Envelope* signal : {&axis.floor, &axis.passive, &axis.active}) list.push_back(signal);
    }
    for (LegHistory& leg : legs_) list.push_back(&leg.force);
    return list;
  }
  // Four base64 digits for three bytes, two bytes a code.
  static std::size_t bytes_of(const Envelope& envelope) {
    return (envelope.part_samples == 1 ? 1 : 2) * envelope.lower.size() * 8 / 3;
  }
  std::size_t bytes() {
    std::size_t sum = 0;
    for (const Envelope* signal : all()) sum += bytes_of(*signal);
    return sum;
  }
  /// Answers false if there is nothing left to halve.
  bool halve_longest() {
    std::size_t longest = 0;
    for (const Envelope* signal : all()) longest = std::max(longest, signal->lower.size());
    for (Envelope* signal : all()) {
      if (2 * signal->lower.size() > longest) *signal = halved(*signal);
    }
    return longest > 1;
  }

  std::vector<HistoryAxis> axes_;
  std::vector<LegHistory> legs_;
};

Json curve_json(const Curve& curve) {
  require(curve.frequencies_hz.size() == curve.values.size(), "spectrum " + curve.name);
  if (curve.empty()) return nullptr;
  return {{"name", curve.name},
          {"f", rounded(curve.frequencies_hz)},
          {"values", rounded(curve.values)}};
}

template <class Thin>
Json signals_json(const SignalCurves& curves, Thin thin) {
  const auto json = [&](const Curve& curve) {
    require(curve.frequencies_hz.size() == curve.values.size(), "spectra");
    return curve.empty() ? Json() : curve_json(thin(curve));
  };
  return {{"floor", json(curves.floor)},
          {"passive", json(curves.passive)},
          {"active", json(curves.active)}};
}

Json spectra_json(const SpectraFigures& spectra) {
  Json axes = Json::array(), criteria = Json::array(), models = Json::array();
  for (const SpectraAxis& axis : spectra.axes) {
    axes.push_back(
        {{"axis", axis.axis},
         {"third_octaves", signals_json(axis.third_octaves, [](const Curve& c) { return c; })},
         {"density", signals_json(axis.density,
                                  [](const Curve& c) { return thin_spectrum(c, spectrum_steps); })},
         {"cumulative_rms", signals_json(axis.cumulative_rms, [](const Curve& c) {
            return thin_cumulative(c, cumulative_steps);
          })}});
  }
  for (const Curve& curve : spectra.criteria) criteria.push_back(curve_json(curve));
  for (const Curve& curve : spectra.models) models.push_back(curve_json(curve));
  return {{"axes", axes}, {"criteria", criteria}, {"models", models}};
}

Json histograms_json(const std::vector<Histogram>& histograms) {
  Json list = Json::array();
  for (const Histogram& histogram : histograms) {
    require(histogram.edges_us.size() == histogram.counts.size() + 1,
            "histogram " + histogram.name);
    list.push_back({{"name", histogram.name},
                    {"edges_us", rounded(histogram.edges_us)},
                    {"counts", histogram.counts}});
  }
  return list;
}

}  // namespace

Json figures_json(const PageData& data) {
  Json figures = Json::object();
  if (data.singular_values)
    figures["singular_values"] = singular_values_json(*data.singular_values);
  if (!data.transmissibility.empty()) {
    figures["transmissibility"] = transmissibility_json(data.transmissibility, "transmissibility");
  }
  if (!data.fit.empty()) figures["fit"] = transmissibility_json(data.fit, "fit");
  if (data.modes && !data.modes->modes.empty()) figures["modes"] = modes_json(*data.modes);
  if (!data.histories.empty() || !data.leg_forces.empty()) {
    figures["histories"] = Histories(data).json();
  }
  if (!data.spectra.axes.empty()) figures["spectra"] = spectra_json(data.spectra);
  if (!data.histograms.empty()) figures["histograms"] = histograms_json(data.histograms);
  return figures;
}

}  // namespace stillframe::page
