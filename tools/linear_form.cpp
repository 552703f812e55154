#include "tools/linear_form.hpp"

#include "report/export/mat_file.hpp"

namespace stillframe::tools {

using Kind = InputColumns::Kind;

const char* word(Kind kind) {
  switch (kind) {
    case Kind::position:
      return "position";
    case Kind::velocity:
      return "velocity";
    case Kind::acceleration:
      return "acceleration";
    case Kind::direct:
      break;
  }
  return "direct";
}

std::vector<ColumnInfo> columns_of(const StateSpace& system) {
  std::vector<ColumnInfo> columns;
  for (size_t j = 0; j < system.columns.size(); ++j) {
    const SignalName& input = system.inputs[j];
    if (system.columns[j].kind == Kind::direct) {
      columns.push_back({input.name, word(Kind::direct), input.unit});
      continue;
    }
    const std::string length = input.unit.substr(0, input.unit.find('/'));
    columns.push_back({input.name, word(Kind::acceleration), length + "/s^2"});
    columns.push_back({input.name, word(Kind::velocity), length + "/s"});
    columns.push_back({input.name, word(Kind::position), length});
  }
  return columns;
}

std::vector<NamedMatrix> second_order_matrices(const LinearModel& m) {
  return {{"M", &m.M},     {"C", &m.C},     {"D", &m.D},     {"K", &m.K},     {"N", &m.N},
          {"G", &m.G},     {"B", &m.B},     {"M_r", &m.M_r}, {"C_r", &m.C_r}, {"D_r", &m.D_r},
          {"K_r", &m.K_r}, {"N_r", &m.N_r}, {"G_r", &m.G_r}, {"Y_p", &m.Y_p}, {"Y_v", &m.Y_v},
          {"Y_a", &m.Y_a}, {"R_p", &m.R_p}, {"R_v", &m.R_v}, {"R_a", &m.R_a}, {"D_u", &m.D_u}};
}

namespace {

std::vector<std::string> names_of(const std::vector<SignalName>& signals) {
  std::vector<std::string> names;
  for (const SignalName& signal : signals) names.push_back(signal.name);
  return names;
}

std::vector<std::string> units_of(const std::vector<SignalName>& signals) {
  std::vector<std::string> units;
  for (const SignalName& signal : signals) units.push_back(signal.unit);
  return units;
}

Json inputs_of(const StateSpace& system) {
  const std::vector<ColumnInfo> columns = columns_of(system);
  Json list = Json::array();
  for (size_t j = 0; j < system.columns.size(); ++j) {
    const InputColumns& input = system.columns[j];
    Json own = Json::array();
    for (Eigen::Index k = input.first; k < input.first + input.width(); ++k) {
      const ColumnInfo& column = columns[static_cast<size_t>(k)];
      own.push_back({{"column", k}, {"of", column.of}, {"unit", column.unit}});
    }
    list.push_back({{"name", system.inputs[j].name},
                    {"unit", system.inputs[j].unit},
                    {"kind", word(input.kind)},
                    {"columns", own}});
  }
  return list;
}

}  // namespace

Json to_json(const LinearModel& model, const StateSpace& system) {
  Json document{{"dofs", model.q_names}, {"dof_units", model.q_units}};
  document["states"] = names_of(system.states);
  document["state_units"] = units_of(system.states);
  document["inputs"] = inputs_of(system);
  Json outputs = Json::array();
  for (const SignalName& output : system.outputs) {
    outputs.push_back({{"name", output.name}, {"unit", output.unit}});
  }
  document["outputs"] = outputs;
  for (const auto& [name, matrix] : second_order_matrices(model)) {
    document["second_order"][name] = to_json(*matrix);
  }
  document["state_space"] = {{"A", to_json(system.A)},
                             {"B", to_json(system.B)},
                             {"C", to_json(system.C)},
                             {"D", to_json(system.D)}};
  document["x0"] = to_json(system.x0);
  document["u0"] = to_json(system.u0);
  document["y0"] = to_json(system.y0);
  return document;
}

void write_mat(const LinearModel& model, const StateSpace& system,
               const std::filesystem::path& path) {
  report::MatFile file(path);
  file.add("A", system.A);
  file.add("B", system.B);
  file.add("C", system.C);
  file.add("D", system.D);
  for (const auto& [name, matrix] : second_order_matrices(model)) {
    // M, C, D, K, N, G and B, which would hide matrices of the first-order form.
    const std::string text = name;
    file.add(text.size() == 1 ? text + "_bar" : text, *matrix);
  }
  file.add("x0", Eigen::MatrixXd(system.x0));
  file.add("u0", Eigen::MatrixXd(system.u0));
  file.add("y0", Eigen::MatrixXd(system.y0));
  file.add("state_names", names_of(system.states));
  file.add("state_units", units_of(system.states));
  file.add("input_names", names_of(system.inputs));
  file.add("input_units", units_of(system.inputs));
  file.add("output_names", names_of(system.outputs));
  file.add("output_units", units_of(system.outputs));
  std::vector<std::string> inputs, of, units;
  for (const ColumnInfo& column : columns_of(system)) {
    inputs.push_back(column.input);
    of.push_back(column.of);
    units.push_back(column.unit);
  }
  file.add("column_inputs", inputs);
  file.add("column_of", of);
  file.add("column_units", units);
  file.save();
}

}  // namespace stillframe::tools
