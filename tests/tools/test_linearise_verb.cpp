#include <matio.h>

#include <bit>
#include <fstream>

#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class LineariseVerb : public Verb {};

void expect_matrix(const Json& found, const std::vector<std::vector<double>>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(found[i].size(), expected[i].size());
    for (size_t j = 0; j < expected[i].size(); ++j) {
      // Four units in the last place: a division by m in two steps.
      EXPECT_DOUBLE_EQ(found[i][j].get<double>(), expected[i][j]) << i << " " << j;
    }
  }
}

/// V1, deck section 11.1: q = x2 - x1, m = 2, d = 4, k = 800.
TEST_F(LineariseVerb, CartIsThatOfTheDeck) {
  const Json model = json({"linearise", config("scenes/cart.yaml")});
  expect_matrix(model["state_space"]["A"], {{0, 1}, {-400, -2}});
  expect_matrix(model["state_space"]["B"], {{0, 0, 0}, {-1, 0, 0}});
  expect_matrix(model["state_space"]["C"], {{1, 0}});
  expect_matrix(model["state_space"]["D"], {{0, 0, 1}});
  expect_matrix(model["second_order"]["M"], {{2}});
  expect_matrix(model["second_order"]["D"], {{4}});
  expect_matrix(model["second_order"]["K"], {{800}});
  const Json input = Json::parse(R"([{"name": "x1", "unit": "m", "kind": "position", "columns": [
      {"column": 0, "of": "acceleration", "unit": "m/s^2"},
      {"column": 1, "of": "velocity", "unit": "m/s"},
      {"column": 2, "of": "position", "unit": "m"}]}])");
  EXPECT_EQ(model["inputs"], input);
  EXPECT_EQ(model["outputs"], Json::parse(R"([{"name": "x2", "unit": "m"}])"));
  EXPECT_EQ(model["states"], Json({"e(spring)", "d/dt e(spring)"}));
  EXPECT_EQ(model["state_units"], Json({"m", "m/s"}));
  expect_documented_keys("linearise", model);
}

TEST_F(LineariseVerb, OperatingPointIsTheEquilibrium) {
  const Json model = json({"linearise", write("scene.yaml", hanging_mass)});
  const double down = 2 * 9.81 / 800;
  // The equilibrium is polished to rounding of the forces.
  EXPECT_NEAR(model["x0"][0].get<double>(), down, 1e-14);
  EXPECT_EQ(model["x0"][1], 0.0);
  EXPECT_NEAR(model["y0"][0].get<double>(), -down, 1e-14);
  EXPECT_EQ(model["u0"][0], 0.0);
  EXPECT_NEAR(model["nodal_displacements"][1]["displacement"][2].get<double>(), -down, 1e-14);
}

TEST_F(LineariseVerb, ReducedModelSaysWhatItLeavesOut) {
  std::ifstream file(config("scenes/cantilever.yaml"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string scene = write("scene.yaml", text + "\nreduce: {modes: 2}\n");
  const Json model = json({"linearise", scene});
  expect_documented_keys("linearise", model);
  const Json& reduction = model["reduction"];
  EXPECT_EQ(reduction["n_modes"], 2);
  EXPECT_EQ(model["dofs"].size(), 2 + reduction["n_corrections"].get<size_t>());
  EXPECT_GT(reduction["first_left_out_hz"].get<double>(), reduction["to_hz"].get<double>());
  ASSERT_EQ(reduction["bounds"].size(), 9);
  for (const Json& row : reduction["bounds"]) {
    EXPECT_LT(row["at_most"].get<double>(), row["largest_singular_value"].get<double>());
  }
  EXPECT_NE(run({"linearise", scene}).output.find("of the difference, at most"), std::string::npos);
  const Said said = run({"linearise", scene, "--certify"});
  EXPECT_EQ(said.exit_code, 2);
  EXPECT_NE(said.error.find("take 'reduce' out"), std::string::npos) << said.error;
}

/// Variables of a MATLAB file, by name.
class ReadMat {
 public:
  explicit ReadMat(const fs::path& file) : file_(Mat_Open(file.c_str(), MAT_ACC_RDONLY)) {}
  ~ReadMat() {
    if (file_ != nullptr) Mat_Close(file_);
  }
  bool is_level_5() const { return file_ != nullptr && Mat_GetVersion(file_) == MAT_FT_MAT5; }

  std::vector<std::vector<double>> matrix(const std::string& name) const {
    matvar_t* variable = Mat_VarRead(file_, name.c_str());
    EXPECT_NE(variable, nullptr) << name;
    if (variable == nullptr) return {};
    EXPECT_EQ(variable->class_type, MAT_C_DOUBLE) << name;
    std::vector rows(variable->dims[0], std::vector<double>(variable->dims[1]));
    const auto* values = static_cast<const double*>(variable->data);
    for (size_t i = 0; i < rows.size(); ++i) {
      for (size_t j = 0; j < rows[i].size(); ++j) rows[i][j] = values[i + j * rows.size()];
    }
    Mat_VarFree(variable);
    return rows;
  }

  std::vector<std::string> texts(const std::string& name) const {
    matvar_t* variable = Mat_VarRead(file_, name.c_str());
    EXPECT_NE(variable, nullptr) << name;
    if (variable == nullptr) return {};
    EXPECT_EQ(variable->class_type, MAT_C_CELL) << name;
    std::vector<std::string> all;
    for (size_t i = 0; i < variable->dims[0]; ++i) {
      const matvar_t* cell = Mat_VarGetCell(variable, static_cast<int>(i));
      all.emplace_back(static_cast<const char*>(cell->data), cell->nbytes);
    }
    Mat_VarFree(variable);
    return all;
  }

 private:
  mat_t* file_;
};

void expect_same_bits(const ReadMat& mat, const std::string& name, const Json& rows) {
  const auto found = mat.matrix(name);
  ASSERT_EQ(found.size(), rows.size()) << name;
  for (size_t i = 0; i < found.size(); ++i) {
    // A vector is a list of numbers in JSON and one column in the file.
    const Json row = rows[i].is_array() ? rows[i] : Json::array({rows[i]});
    ASSERT_EQ(found[i].size(), row.size()) << name;
    for (size_t j = 0; j < row.size(); ++j) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(found[i][j]),
                std::bit_cast<std::uint64_t>(row[j].get<double>()))
          << name << " " << i << " " << j;
    }
  }
}

TEST_F(LineariseVerb, MatFileHoldsTheSameBitsAsTheJson) {
  // Moving scenes, so that all six matrices have numbers in them.
  for (const char* scene : {"cart", "slider_crank", "spinning_arm"}) {
    const fs::path file = folder_ / (std::string(scene) + ".mat");
    // The spinning arm is not stable, and warned of.
    const Said said = run({"linearise", config(std::string("scenes/") + scene + ".yaml"), "--mat",
                           file.string(), "--json"});
    ASSERT_EQ(said.exit_code, 0) << said.error;
    const Json model = Json::parse(said.output);
    const ReadMat mat(file);
    ASSERT_TRUE(mat.is_level_5());
    for (const char* name : {"A", "B", "C", "D"}) {
      expect_same_bits(mat, name, model["state_space"][name]);
    }
    for (const auto& [name, rows] : model["second_order"].items()) {
      expect_same_bits(mat, name.size() == 1 ? name + "_bar" : name, rows);
    }
    for (const char* name : {"x0", "u0", "y0"}) expect_same_bits(mat, name, model[name]);
    std::vector<std::string> inputs, column_units;
    for (const Json& input : model["inputs"]) {
      inputs.push_back(input["name"]);
      for (const Json& column : input["columns"]) column_units.push_back(column["unit"]);
    }
    EXPECT_EQ(mat.texts("input_names"), inputs);
    EXPECT_EQ(mat.texts("column_units"), column_units);
    EXPECT_EQ(mat.texts("state_names"), model["states"].get<std::vector<std::string>>());
    EXPECT_EQ(mat.texts("state_units"), model["state_units"].get<std::vector<std::string>>());
  }
}

TEST_F(LineariseVerb, EveryNameInTheMatFileIsDocumented) {
  const fs::path file = folder_ / "cart.mat";
  ASSERT_EQ(run({"linearise", config("scenes/cart.yaml"), "--mat", file}).exit_code, 0);
  const std::string help = run({"linearise", "--help"}).output;
  mat_t* mat = Mat_Open(file.c_str(), MAT_ACC_RDONLY);
  ASSERT_NE(mat, nullptr);
  size_t n = 0;
  char* const* names = Mat_GetDir(mat, &n);
  EXPECT_EQ(n, 36u);
  for (size_t i = 0; i < n; ++i) {
    // "state_, input_, output_names and _units" stands for six of them.
    std::string name = names[i];
    for (const char* end : {"_names", "_units"}) {
      const size_t at = name.find(end);
      if (at != std::string::npos && !name.starts_with("column")) name.resize(at + 1);
    }
    // M_r ... D_u stands for those between.
    if (name.ends_with("_r") || name.ends_with("_p") || name.ends_with("_v") ||
        name.ends_with("_a")) {
      continue;
    }
    EXPECT_NE(help.find(name), std::string::npos) << name;
  }
  Mat_Close(mat);
}

TEST_F(LineariseVerb, PageHoldsSmallMatricesAndPointsToTheRest) {
  const std::string cart = run({"linearise", config("scenes/cart.yaml")}).output;
  EXPECT_NE(cart.find("-400  -2"), std::string::npos) << cart;
  EXPECT_NE(cart.find("1-3: acceleration, velocity, position"), std::string::npos) << cart;
  EXPECT_NE(cart.find("N (1 x 1) = 0"), std::string::npos) << cart;
  const std::string frame = run({"linearise", config("scenes/metrology_frame.yaml")}).output;
  EXPECT_NE(frame.find("A (12 x 12): too wide for the page"), std::string::npos) << frame;
  EXPECT_NE(frame.find("347.222"), std::string::npos) << frame;
}

TEST_F(LineariseVerb, FailedWritesLeaveNothing) {
  expect_refused(
      {"linearise", config("scenes/cart.yaml"), "--mat", folder_ / "none/cart.mat"}, 2,
      "--mat: found '" + (folder_ / "none/cart.mat").string() + "', but there is no folder");
  fs::create_directories(folder_ / "folder.mat/in_use");
  expect_refused({"linearise", config("scenes/cart.yaml"), "--mat", folder_ / "folder.mat"}, 2,
                 "folder.mat', which is a folder; allowed is the name of a file");
  EXPECT_FALSE(fs::exists(folder_ / "none"));
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_EQ(entry.path().string().find("incomplete"), std::string::npos) << entry.path();
  }
}

TEST_F(LineariseVerb, MasslessDofIsRefusedByName) {
  std::string text = hanging_mass;
  text.replace(text.find("mass: 2}"), 8, "mass: 0}");
  const Said said = run({"linearise", write("scene.yaml", text)});
  EXPECT_NE(said.exit_code, 0);
  // Without the mass altogether, nothing is heavy.
  text.replace(text.find("  - {node: mass, mass: 0}\n"), 26, "");
  text.replace(text.find("masses:"), 7, "masses: []");
  expect_refused({"linearise", write("scene.yaml", text)}, 3,
                 "the mass matrix is not positive definite: dof e(spring) moves no mass");
}

// Each number is within its range, and 12 EI / l^3 / m = 1.2e331 1/s^2 is no number.
TEST_F(LineariseVerb, NumbersThatOverflowTogetherAreRefusedByName) {
  const auto scene = write("scene.yaml", R"(title: A cantilever that is far too short
planar: true
nodes: {root: {position: [0, 0]}, tip: {position: [1e-90, 0]}}
masses: [{node: tip, mass: 1e-30}]
elements: {beam: {type: beam, nodes: [root, tip], rigid: [1], EI: 1e30}}
supports: [{nodes: [root], fix: [x, y, rotation]}, {nodes: [tip], fix: [rotation]}]
dofs: [{node: tip, along: y}]
inputs: [{name: push, force: tip, along: y}]
outputs: [{name: tip, acceleration: tip, along: y}]
)");
  for (const char* verb : {"linearise", "sigma"}) {
    expect_refused({verb, scene}, 3,
                   "numbers of the model overflow: the acceleration of dof y(tip) is not finite");
  }
  expect_refused({"modes", scene}, 3,
                 "numbers of the model overflow: a natural frequency is not finite");
}

// A hinge of 1.5e-3 N m/rad beside a leg of 2e9 N/m: other units, and no rounding of it.
TEST_F(LineariseVerb, PageHasWhatIsSmallInOtherUnits) {
  const std::string page = run({"linearise", write("scene.yaml", R"(title: A soft hinge
planar: true
nodes:
  g: {position: [0, 0]}
  a: {position: [1, 0]}
  h: {position: [1, 0]}
  b: {position: [1, 0.01]}
masses: [{node: a, mass: 100}, {node: b, mass: 1e-6, inertia: 1e-12}]
elements:
  leg: {type: truss, nodes: [g, a], stiffness: 2e9}
  hinge: {type: hinge, nodes: [a, h], stiffness: 1.5e-3}
  arm: {type: rigid_beam, nodes: [h, b]}
supports: [{nodes: [g], fix: [x, y]}, {nodes: [a], fix: [y, rotation]}]
dofs: [{element: leg}, {element: hinge}]
)")})
                               .output;
  EXPECT_NE(page.find("K (2 x 2)\n  2e+09       0\n      0  0.0015\n"), std::string::npos) << page;
}

}  // namespace
}  // namespace stillframe::test
