#include <fstream>
#include <sstream>

#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

/// The plate of examples/superelement, as CalculiX meshes and solves it.
class SuperelementVerb : public Verb {
 protected:
  static std::vector<std::string> interfaces() {
    return {"--interface", "mount_1=MOUNT_1@0.6,0,-0.1",
            "--interface", "mount_2=MOUNT_2@-0.3,0.519615242270663,-0.1",
            "--interface", "mount_3=Mount_3@-0.3,-0.519615242270663,-0.1",
            "--interface", "lens=LENS@0,0,0.05"};
  }
  /// Meshes and solves the plate of the example in the folder.
  void solve_plate() const {
    const Said said = shell("cd '" + folder_.string() +
                            "' && python3 '" STILLFRAME_SOURCE_DIR
                            "/examples/superelement/plate.py' && ccx plate && ccx plate_free");
    ASSERT_EQ(said.exit_code, 0) << said.output << said.error;
  }
  std::vector<std::string> call(std::vector<std::string> more) const {
    std::vector<std::string> all{"superelement", (folder_ / "plate").string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::vector<std::string> reduced(const std::string& modes, const std::string& out) const {
    std::vector<std::string> more = interfaces();
    for (const auto& each :
         {std::string("--modes"), modes, std::string("--out"), (folder_ / out).string()}) {
      more.push_back(each);
    }
    return call(more);
  }
  std::string free_plate(const std::string& body) const {
    return "title: plate\nnodes:\n  a: {position: [0.6, 0, -0.1]}\n"
           "  b: {position: [-0.3, 0.519615242270663, -0.1]}\n"
           "  c: {position: [-0.3, -0.519615242270663, -0.1]}\n  d: {position: [0, 0, 0.05]}\n"
           "masses: []\nelements: {plate: {type: superelement, nodes: [a, b, c, d], body: '" +
           body + "'}}\ndofs: auto\n";
  }
  std::vector<double> elastic_frequencies(const std::string& body) const {
    const auto all =
        json({"modes", write("free.yaml", free_plate(body)).string()})["natural_frequencies_hz"]
            .get<std::vector<double>>();
    return {all.begin() + 6, all.end()};
  }
  /// Frequencies of the table in CalculiX's .dat, behind the six rigid modes.
  std::vector<double> calculix() const {
    std::istringstream text(text_of(folder_ / "plate_free.dat"));
    std::vector<double> found;
    for (std::string line; std::getline(text, line) && found.size() < 26;) {
      std::istringstream row(line);
      double number = 0, value = 0, radians = 0, hz = 0;
      if (row >> number >> value >> radians >> hz && number == double(found.size()) + 1) {
        found.push_back(hz);
      }
    }
    EXPECT_EQ(found.size(), 26u);
    return {found.begin() + 6, found.end()};
  }
};

TEST_F(SuperelementVerb, AMeshOfCalculixVibratesAsItDoesThere) {
  solve_plate();
  const auto document = json(reduced("20", "plate.yaml"));
  expect_documented_keys("superelement", document);
  EXPECT_EQ(document["n_mesh_dofs"], 6669);
  // 2700 kg/m^3 of 1.4 x 1.3 x 0.15 m, which the deck's nodes have to twelve digits.
  EXPECT_NEAR(document["mass_kg"].get<double>(), 737.1, 1e-8);
  EXPECT_NEAR(document["centre_of_mass_m"][2].get<double>(), -0.025, 1e-9);
  EXPECT_NEAR(document["inertia_kg_m2"][2][2].get<double>(), 737.1 / 12 * (1.4 * 1.4 + 1.3 * 1.3),
              1e-6);
  const auto expected = calculix();
  const auto found = elastic_frequencies("plate.yaml");
  const auto told = document["mode_frequencies_hz"].get<std::vector<double>>();
  ASSERT_EQ(told.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    // It prints seven digits.
    EXPECT_NEAR(found[i], expected[i], 1e-6 * expected[i]) << i;
    EXPECT_NEAR(found[i], told[i], 1e-8 * told[i]) << i;
  }
  EXPECT_GT(document["first_left_out_hz"].get<double>(), told.back());

  // The body that is shipped is this one, but for the rounding of the text.
  const auto shipped = elastic_frequencies(config("bodies/plate.yaml"));
  ASSERT_EQ(shipped.size(), found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(shipped[i], found[i], 1e-7 * found[i]) << i;
  }

  // Fewer modes are those, and never below: the basis is a smaller one. All of a band likewise.
  for (std::vector<std::string> more :
       {std::vector<std::string>{"--modes", "5"}, {"--modes-to-hz", "700"}}) {
    for (const std::string& word : interfaces()) more.push_back(word);
    for (const char* word : {"--out", "few.yaml"}) more.emplace_back(word);
    more.back() = (folder_ / "few.yaml").string();
    const auto few = json(call(more));
    EXPECT_EQ(few["n_modes"], 5);
    EXPECT_NEAR(few["first_left_out_hz"].get<double>(), told[5], 1e-8 * told[5]);
    const auto less = elastic_frequencies("few.yaml");
    for (std::size_t i = 0; i < less.size() && i < 20; ++i) {
      EXPECT_GE(less[i], found[i] * (1 - 1e-8)) << i;
      if (i < 5) {
        EXPECT_NEAR(less[i], found[i], 1e-8 * found[i]) << i;
      }
    }
  }

  // Of a single interface, which is as rigid there as it is beside the others.
  const auto one = json(call({"--interface", "d=LENS@0,0,0.05", "--modes", "3", "--out",
                              (folder_ / "one.yaml").string()}));
  const auto hz = json({"modes", write("one_free.yaml",
                                       "title: plate\nnodes: {d: {position: [0, 0, 0.05]}}\n"
                                       "masses: []\nelements: {plate: {type: superelement, nodes: "
                                       "[d], body: 'one.yaml'}}\ndofs: auto\n")
                                     .string()})["natural_frequencies_hz"];
  ASSERT_EQ(hz.size(), 9u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double expected = one["mode_frequencies_hz"][i];
    EXPECT_NEAR(hz[6 + i].get<double>(), expected, 1e-7 * expected) << i;
  }
}

// The plate on its six legs and piezos, by the design, the controller, the nonlinear plant and the
// log: singular values as predicted (the scene's checks).
TEST_F(SuperelementVerb, TheMeshedFrameIsIsolatedAsPredicted) {
  const Said said = run({"run", config("scenes/meshed_frame.yaml"), "--mode", "single_process",
                         "--duration", "4", "--out", folder_ / "run"});
  EXPECT_EQ(said.exit_code, 0) << said.output << said.error;
  const auto verdict = nlohmann::json::parse(text_of(folder_ / "run/verdict.json"));
  int n_predictions = 0;
  for (const auto& check : verdict["checks"]) {
    const auto name = check.dump();
    if (name.find("against the prediction") != std::string::npos) ++n_predictions;
  }
  EXPECT_EQ(n_predictions, 2) << verdict["checks"].dump(1);
}

/// A cube of eight nodes between which springs are: what CalculiX would write of it.
class SmallMesh : public SuperelementVerb {
 protected:
  void SetUp() override {
    SuperelementVerb::SetUp();
    write("cube.inp",
          "** a comment\n*NODE, NSET=ALL\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 1., 1, 0\n"
          "5, 0, 0, 1\n6, 1, 0, 1\n7, 0, 1, 1\n8, 1e0, 1, 1\n*NSET, NSET=LOW, GENERATE\n1, 4\n"
          "*nset, nset=High\n5, 6, 7,\n8\n*Nset, Nset=Both\nLOW, high\n*NSET, NSET=LINE\n1, 2\n");
    std::string dofs, mass, stiffness;
    for (int i = 0; i < 24; ++i) {
      dofs += std::to_string(i / 3 + 1) + "." + std::to_string(i % 3 + 1) + "\n";
      mass += std::to_string(i + 1) + " " + std::to_string(i + 1) + " 0.5\n";
    }
    double K[24][24] = {};
    for (int a = 0; a < 8; ++a) {
      for (int b = 0; b < a; ++b) {
        const double d[3] = {double(a & 1) - (b & 1), double(a >> 1 & 1) - (b >> 1 & 1),
                             double(a >> 2) - (b >> 2)};
        const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            const double k = 1000 * d[i] * d[j] / square;
            K[3 * a + i][3 * a + j] += k;
            K[3 * b + i][3 * b + j] += k;
            K[3 * a + i][3 * b + j] -= k;
            K[3 * b + i][3 * a + j] -= k;
          }
        }
      }
    }
    std::ostringstream text;
    text.precision(17);
    for (int i = 0; i < 24; ++i) {
      for (int j = i; j < 24; ++j) {
        if (K[i][j] != 0) text << i + 1 << ' ' << j + 1 << ' ' << K[i][j] << '\n';
      }
    }
    write("cube.dof", dofs);
    write("cube.mas", mass);
    write("cube.sti", text.str());
  }
  void refused(const std::vector<std::string>& more, const std::string& why) const {
    std::vector<std::string> all{"superelement", (folder_ / "cube.inp").string(), "--out",
                                 (folder_ / "cube.yaml").string()};
    all.insert(all.end(), more.begin(), more.end());
    expect_refused(all, 2, why);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "cube.yaml"));
  }
};

TEST_F(SmallMesh, IsReducedToItsInterfaces) {
  const auto document =
      json({"superelement", folder_ / "cube", "--interface", "low=low", "--interface", "high=HIGH",
            "--modes", "0", "--out", folder_ / "cube.yaml"});
  EXPECT_EQ(document["n_dofs"], 12);
  EXPECT_EQ(document["mass_kg"], 4);
  EXPECT_EQ(document["mode_frequencies_hz"].size(), 0u);
  const std::string body = text_of(folder_ / "cube.yaml");
  EXPECT_NE(body.find("low: [0.5, 0.5, 0]"), std::string::npos) << body;
}

TEST_F(SmallMesh, AMeshThatReadsLikeMillimetresIsToldOf) {
  const Said far = run({"superelement", (folder_ / "cube").string(), "--interface", "d=HIGH@0,0,50",
                        "--modes", "3", "--out", folder_ / "far.yaml"});
  EXPECT_EQ(far.exit_code, 0) << far.error;
  EXPECT_NE(far.error.find("mesh and interfaces are 50 m long; if that is millimetres"),
            std::string::npos)
      << far.error;
}

TEST_F(SmallMesh, WhatIsWrongIsSaidAndNothingIsWritten) {
  refused({}, "--interface NAME=SET is needed at least once");
  refused({"--interface", "LOW"}, "allowed is NAME=SET or NAME=SET@x,y,z");
  refused({"--interface", "a b=LOW"}, "letters, digits");
  refused({"--interface", "a=LOW@1,2"}, "three numbers");
  refused({"--interface", "a=LOW@1,2,3,4"}, "behind the point");
  refused({"--interface", "a=LOWS"},
          "there is no set of nodes named 'LOWS' in the mesh; the "
          "nearest name is 'LOW'");
  refused({"--interface", "a=LOW", "--interface", "a=HIGH"}, "of that name already");
  refused({"--interface", "a=LOW", "--interface", "b=BOTH"}, "belongs to another interface");
  refused({"--interface", "a=LINE", "--modes", "1"}, "without stiffness");
  refused({"--interface", "a=LOW", "--modes", "90"}, "allowed with 1 interfaces are up to 12");
  refused({"--interface", "a=LOW", "--modes-to-hz", "-1"}, "--modes-to-hz");
  const std::vector<std::string> sound{"--interface", "a=LOW", "--modes", "1"};
  const auto broken = [&](const char* file, const std::string& text, const std::string& why) {
    const std::string before = text_of(folder_ / file);
    write(file, text);
    refused(sound, why);
    write(file, before);
  };
  broken("cube.dof", "1.1\n1.4\n", "cube.dof:2: found '1.4', allowed are directions 1 to 3");
  broken("cube.dof", "1.1\n1.1\n", "cube.dof:2: found '1.1', allowed is each degree of freedom");
  broken("cube.dof", "9.1\n", "cube.dof:1: found '9.1', allowed are nodes of the deck");
  broken("cube.dof", "1\n", "cube.dof:1: found '1', allowed is node.direction");
  broken("cube.dof", "", "cube.dof: has no degrees of freedom");
  std::string without = text_of(folder_ / "cube.dof");
  without.erase(0, 4);
  broken("cube.dof", without, "cube.sti:");
  broken("cube.sti", "1 1\n", "cube.sti:1: found '1 1', allowed are row, column (1 to 24)");
  broken("cube.mas", "1 1 inf\n", "cube.mas:1: found '1 1 inf'");
  broken("cube.inp", "*NODE\n1, 2, x, 3\n", "cube.inp:2: found '1, 2, x, 3'");
  broken("cube.inp", "*INCLUDE, INPUT=none.inp\n", "none.inp: cannot be read");
  broken("cube.inp", "*INCLUDE, INPUT=cube.inp\n", "include each other");
  broken("cube.inp", "*NSET, NSET=A\nB\n", "cube.inp:2: found 'B', allowed are numbers of nodes");
  // A body that something holds is no free body.
  std::string held = text_of(folder_ / "cube.sti");
  held.insert(0, "24 24 500\n");
  broken("cube.sti", held, "resists a rigid");
  std::filesystem::remove(folder_ / "cube.mas");
  refused(sound, "cube.mas: cannot be read");
}

}  // namespace
}  // namespace stillframe::test
