#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <random>

#include "tests/tools/verb.hpp"
#include "tools/spacar/sections.hpp"

namespace stillframe::test {
namespace {

using ImportedJson = nlohmann::json;

/// Two leaves of 100 x 50 x 0.2 mm that carry a plate of 1.5 kg/m, as a SPACAR file. Numbers:
/// Wout-S/oopspa, testfile.dat of its commit bcad60f, without its displacement.
constexpr const char* leaf_guide_dat = R"(# two leaves
X 1 0 0 0
X 4 0 0.1 0
X 7 0.1 0.1 0
X 10 0.1 0 0
BEAM 1 1 2 4 5 0 0 1
BEAM 2 7 8 10 11 0 0 1
BEAM 3 4 5 7 8 0 0 1
DYNE 1 4 6
RLSE 1 1 2 3 5
DYNE 2 1 5 6
RLSE 2 2 3 4
FIX 1 1 2 3
FIX 2 2 3 4
FIX 10 1 2 3
FIX 11 2 3 4
INPUTX 7 1
END
HALT
ESTIFF 1 2.1e6 0.009309804722106 0.007 437.5 1.1666667e-8 7.29166666667e-4
ESTIFF 2 2.1e6 0.009309804722106 0.007 437.5 1.1666667e-8 7.29166666667e-4
EM 1 0.078 1.625026e-5 2.6e-10 1.625e-5 0
EM 2 0.078 1.625026e-5 2.6e-10 1.625e-5 0
EM 3 1.5 3.25e-4 1.25e-5 3.125e-4 0
XM 7 0.1
GRAVITY 0 0 -9.81
END
END
)";

/// A mirror on three leaves that warp. Numbers: Echolite007/MOD8, spacar_file.dat.
constexpr const char* mirror_dat = R"(X 1 0 0.023438 0
X 4 0.062225 0.023438 0.062225
X 7 0 0.164062 0
X 10 0.062225 0.164062 0.062225
X 13 0 0.09375 0.062225
X 16 0.062225 0.09375 0
X 19 0.062225 0.09375 0.062225
X 22 0.08756 0.09366 0.062225
X 25 0.03633 0.09407 0.06697
X 28 0.031113 0.09375 0.031113
X 31 -0.03126 0.08617 0.07951
BEAMW 1 1 2 3 4 5 6 0 1 0
BEAMW 2 7 8 9 10 11 12 0 1 0
BEAMW 3 13 14 15 16 17 18 0 1 0
BEAMW 4 19 20 21 13 14 15 0 1 0
BEAM 5 4 5 19 20 1 0 0
BEAM 6 10 11 19 20 1 0 0
BEAM 7 22 23 19 20 1 0 0
BEAM 8 25 26 19 20 1 0 0
BEAM 9 28 29 19 20 1 0 0
BEAM 10 13 14 31 32 1 0 0
DYNE 1 1 3 4
RLSE 1 2 5 6
DYNE 2 1 3
RLSE 2 2 4 5 6
DYNE 3 6
RLSE 3 1 2 3 4 5
FIX 1
FIX 2
FIX 7
FIX 8
FIX 16
FIX 17
FIX 3
FIX 9
FIX 15
FIX 18
FIX 21
END
HALT
ESTIFF 1 1875000 0.009848446281614 0.00625 343.32275390625 9.949367e-9 5.46535057358e-4 1.14440918e-6
ESTIFF 2 1875000 0.009848446281614 0.00625 343.32275390625 9.949367e-9 5.46535057358e-4 1.14440918e-6
ESTIFF 3 3750000 0.019723446281614 0.0125 2746.58203125 9.949367e-9 2.186140229430e-3 9.155273438e-6
EM 1 0.073125 1.3389831152e-5 2.4375e-10 1.3389587402e-5 0 4.5e-14
EM 2 0.073125 1.3389831152e-5 2.4375e-10 1.3389587402e-5 0 4.5e-14
EM 3 0.14625 1.07117186719e-4 4.875e-10 1.07116699219e-4 0 3.57e-13
XM 25 0.31385
XM 26 0.000381 -0.000007 -0.000034 0.000727 0.000001 0.001065
GRAVITY 0 -9.81 0
END
HALT
INPUTF 1 22 3
OUTXP 1 22 3
OUTX 2 31 1
END
END
)";

/// A cantilever of SPACAR Light with a tip mass.
constexpr const char* cantilever_m = R"(% a strip
clear, clc
L = 0.2; t = 1e-3;
nodes = [0 0 0; L 0 0];
elements = [1 2];
nprops(1).fix = true;
nprops(2).mass = 0.05;
eprops(1).elems = 1;
eprops(1).emod = 210e9;
eprops(1).smod = 70e9;
eprops(1).dens = 7800;
eprops(1).cshape = 'rect';
eprops(1).dim = [20*t t];
eprops(1).orien = [0 0 1];
eprops(1).nbeams = 4;
eprops(1).flex = 1:6;
out = spacarlight(nodes, elements, nprops, eprops);
plot(out.freq)
)";

class ImportVerb : public Verb {
 protected:
  ImportedJson imported(const std::string& file, const std::string& text, int exit_code = 0) const {
    return json({"import", write(file, text), "--out", folder_ / "scene.yaml"}, exit_code);
  }

  std::string scene() const { return text_of(folder_ / "scene.yaml"); }

  std::vector<double> frequencies(const std::filesystem::path& file) const {
    return json({"modes", file})["natural_frequencies_hz"].get<std::vector<double>>();
  }

  void expect_in_scene(const std::string& piece) const {
    EXPECT_NE(scene().find(piece), std::string::npos) << piece << "\n" << scene();
  }

  /// Refused with the place, and nothing written.
  void expect_bad(const std::string& file, const std::string& text,
                  const std::string& message) const {
    expect_refused({"import", write(file, text), "--out", folder_ / "bad.yaml"}, 2, message);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "bad.yaml")) << message;
  }
};

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

std::string replaced_everywhere(const std::string& text, char what, const std::string& by) {
  std::string out;
  for (const char c : text) {
    if (c == what) {
      out += by;
    } else {
      out += c;
    }
  }
  return out;
}

// --- numbers of SPACAR itself

TEST_F(ImportVerb, LeafGuideHasTheFrequenciesOfSpacar) {
  const ImportedJson document = imported("guide.dat", leaf_guide_dat);
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  // What SPACAR wrote of it: roots of M0 and K0 + N0 + G0 in testfile.sbm, before it is displaced.
  const std::array spacar{443.53397987, 1078.7322599, 1829.35927233, 3350.29826211, 4060.36050011};
  const std::vector<double> ours = frequencies(folder_ / "scene.yaml");
  ASSERT_EQ(ours.size(), spacar.size());
  // The numbers of the file have nine digits or more, its roots are of a matrix of condition 1e6.
  for (std::size_t i = 0; i < ours.size(); ++i) EXPECT_NEAR(ours[i] / spacar[i], 1, 3e-8) << i;
  expect_documented_keys("import", document);
}

TEST_F(ImportVerb, MirrorOnLeavesThatWarpHasTheFrequenciesOfSpacar) {
  const ImportedJson document = imported("mirror.dat", mirror_dat);
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  EXPECT_EQ(document["approximated"].size(), 3u);
  const std::array spacar{2.50250421, 866.890589, 1298.46178, 1826.90690, 2285.52581, 3241.47077};
  const std::vector<double> ours = frequencies(folder_ / "scene.yaml");
  ASSERT_EQ(ours.size(), spacar.size());
  // SPACAR's leaves have warping as a coordinate of its own, ours a stiffer torsion.
  for (std::size_t i = 0; i < ours.size(); ++i) EXPECT_NEAR(ours[i] / spacar[i], 1, 2e-5) << i;
  expect_in_scene("{name: outx_2, position: n31, along: x}");
  expect_in_scene("{name: inputf_1, force: n22, along: z}");
}

TEST_F(ImportVerb, CrossHingeOfAScriptHasTheFrequenciesOfSpacar) {
  // The cross hinge that SPACAR Light comes with; what SPACAR made of it: Wout-S/oopspa,
  // crosshinge_3.sbm of its commit bcad60f, first step.
  const ImportedJson document = imported("hinge.m", R"(
nodes = [0 0 0; 0 0.1 0; 0.1 0.1 0; 0.1 0 0];
elements = [1 3; 2 3; 2 4];
nprops(1).fix = true; nprops(3).mass = 0.1; nprops(4).fix = true;
eprops(1).elems = [1 3]; eprops(1).emod = 210e9; eprops(1).smod = 70e9; eprops(1).dens = 7800;
eprops(1).cshape = 'rect'; eprops(1).dim = [50e-3 0.2e-3]; eprops(1).orien = [0 0 1];
eprops(1).flex = 1:6;
eprops(2).elems = 2; eprops(2).dens = 3000; eprops(2).cshape = 'rect';
eprops(2).dim = [50e-3 10e-3]; eprops(2).orien = [0 0 1];
opt.gravity = [0 0 -9.81];
out = spacarlight(nodes, elements, nprops, eprops, opt);
)");
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  const std::array spacar{1.56539102, 266.482056, 524.83797, 1206.97796, 2257.55152, 2586.64469};
  const std::vector<double> ours = frequencies(folder_ / "scene.yaml");
  ASSERT_EQ(ours.size(), spacar.size());
  // SPACAR Light ends its series of the torsion constant at 1e-4 of the sum, and the weight of the
  // hinge counts in the first.
  for (std::size_t i = 0; i < ours.size(); ++i) EXPECT_NEAR(ours[i] / spacar[i], 1, 1e-5) << i;
}

// --- against scenes by hand

TEST_F(ImportVerb, LightScriptIsTheSceneByHand) {
  const ImportedJson document = imported("strip.m", cantilever_m);
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  EXPECT_EQ(document["no_part"].size(), 1u) << document["no_part"];
  EXPECT_EQ(document["no_part"][0]["line"], 18);
  // J of a rectangle 20 : 1 is 0.32283 of w t^3 (Timoshenko and Goodier have 0.3228 at 20), k 6/7
  // at v = 0.5.
  const std::string by_hand = R"(title: by hand
nodes: {a: {position: [0, 0, 0]}, b: {position: [0.2, 0, 0]}}
elements:
  s: {type: beam, nodes: [a, b], orientation: [0, 0, 1], EA: 4.2e6, GJ: 0.4519, EI_y: 0.35, EI_z: 140,
    shear_y: 1.2e6, shear_z: 1.2e6, mass_per_length: 0.156, inertia_per_length: 5.2131e-6,
    second_order: true, divide: 4}
masses: [{node: b, mass: 0.05}]
supports: [{nodes: [a], fix: [x, y, z, rotation]}]
dofs: auto
)";
  const std::vector<double> ours = frequencies(folder_ / "scene.yaml"),
                            hand = frequencies(write("hand.yaml", by_hand));
  ASSERT_EQ(ours.size(), hand.size());
  // The scene by hand has the rotary inertia about the beam alone, and J to four digits.
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(ours[i] / hand[i], 1, 2e-3) << i;
  EXPECT_NEAR(ours[0] / hand[0], 1, 1e-5);
}

TEST_F(ImportVerb, SectionsAreThoseOfTheBooks) {
  using namespace tools::spacar;
  // Timoshenko and Goodier, table of article 109: J = k1 a^3 b.
  EXPECT_NEAR(rectangle_torsion_constant(1, 1), 0.1406, 5e-5);
  EXPECT_NEAR(rectangle_torsion_constant(2, 1), 2 * 0.229, 1e-3);
  EXPECT_NEAR(rectangle_torsion_constant(1, 10), 10 * 0.312, 5e-3);
  const Section round{.circular = true,
                      .width = 2,
                      .thickness = 2,
                      .e_modulus = 3,
                      .g_modulus = 1.25,
                      .density = 5};
  const std::vector<double> S = section_stiffness(round), m = section_inertia(round);
  const double pi = 3.141592653589793;
  EXPECT_NEAR(S[0], 3 * pi, 1e-14);
  EXPECT_NEAR(S[1], 1.25 * pi / 2, 1e-14);
  EXPECT_NEAR(S[2], 3 * pi / 4, 1e-14);
  // Cowper's k of a circle at v = 0.2 is 7.2 / 8.2.
  EXPECT_NEAR(S[4], (3 * pi / 4) / (7.2 / 8.2 * 1.25 * pi), 1e-14);
  EXPECT_NEAR(m[1], m[2] + m[3], 1e-14);
  // Short strips that cannot warp bend instead: 12 E I_w / L^3 of each end.
  EXPECT_NEAR(warping_factor(1, 1, 0.01, 2), 12 / 1e-4, 12);
  EXPECT_NEAR(warping_factor(1, 1, 0.01, 1), 3 / 1e-4, 3);
  EXPECT_NEAR(warping_factor(1, 1, 1e6, 2), 1, 1e-5);
  EXPECT_EQ(warping_factor(1, 1, 1, 0), 1);
}

// --- every keyword

TEST_F(ImportVerb, EveryPlanarKeyword) {
  const ImportedJson document = imported("all.dat", R"(! planar, in small letters too
plbeam 1 1 2 3 4
PLTRUSS 2 3 5
PLHINGE 3 4 6
PLRBEAM 4 3 6 7
PLTRUSS 5 3 8
PLBEAM 6 9 10 3 4
X 1 0 0
X 3 1 0
X 5 1 1
X 7 2 0
X 8 1 -1
X 9 0 1
FIX 1 1 2
FIX 2
FIX 5
FIX 8 1
FIX 10
FIX 9 1
INPUTX 9 2
INPUTX 8 2
DYNE 1 1 2 3
RLSE 2 1
DYNE 3 1
INPUTE 5 1
DYNX 7 2
RLSE 6
END
HALT
ESTIFF 1 1.0D9 3e7 0.003   % EA, EI, EI / (k G A)
ESTIFF 2 500
ESTIFF 3 7e4
ESTIFF 6 10 20
EDAMP 1 4 2
EDAMP 2 3
EDAMP 3 0.25
EM 1 2 0.01
EM 2 3
EM 6 1
ESIG 2 11
ESIG 3 0.5
XM 7 4
XM 6 0.125
XF 7 1 -2
DELXF 7 0.5 0
XF 4 9
INPUTX 8 2 -0.9921875
DELINPX 8 2 0.0078125
INPUTE 5 1 0.015625 0 0
STARTDE 1 2 0 0
GRAVITY 0 -9.81
TIMESTEP 1 100
ITERSTEP 10 1 5e-7
END
HALT
INPUTF 1 7 2
INPUTF 2 6 1
INPUTS 3 2 1
OUTX 1 7 1
OUTX 2 6 1
OUTXP 3 7 1
OUTE 4 2 1
OUTEP 5 3 1
END
END
picture 1
)");
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  EXPECT_EQ(document["no_part"].size(), 3u);
  expect_in_scene("planar: true");
  expect_in_scene("gravity: [0, -9.81] ");
  expect_in_scene("  n3r4: {position: [1, 0]}");
  expect_in_scene("e1: {type: beam, nodes: [n1, n3r4], EA: 1e+09, EI: 3e+07, shear: 1e+10,");
  expect_in_scene("damping: [[4, 0, 0], [0, 8, -4], [0, -4, 8]]");
  expect_in_scene("e2: {type: truss, nodes: [n3, n5], stiffness: 500, damping: 3, preload: 11}");
  expect_in_scene(
      "e3: {type: hinge, nodes: [n3r4, n3], stiffness: 70000, damping: 0.25, preload: 0.5}");
  expect_in_scene("e4: {type: rigid_beam, nodes: [n3, n7]}");
  expect_in_scene("{node: n7, mass: 4}");
  expect_in_scene("{node: n3, mass: 1.5, inertia: 0.125}");
  expect_in_scene("{node: n7, force: [1.5, -2]}");
  expect_in_scene("{node: n3r4, torque: 9}");
  expect_in_scene("{nodes: [n8], move: [y], value: 0.015625}");
  expect_in_scene("{element: e5, mode: 1, value: 0.015625}");
  expect_in_scene("{name: inputs_3, stress: e2, mode: 1}");
  expect_in_scene("{name: outep_5, deformation_rate: e3, mode: 1}");
  expect_in_scene("{name: outx_2, rotation: n3}");
  expect_in_scene("{name: inputf_2, torque: n3}");
  EXPECT_EQ(run({"linearise", folder_ / "scene.yaml"}).error, "");
}

TEST_F(ImportVerb, EverySpatialKeyword) {
  const ImportedJson document = imported("all.dat", R"(
X 1 0 0 0
X 3 1 0 0
X 5 1 1 0
X 7 2 0 0
X 9 0 0 1
BEAM 1 1 2 3 4 0 1 0
TRUSS 2 3 5
HINGE 3 4 6 0 0 1
PINBODY 4 3 6 7
RBEAM 5 7 6 9
TRUSS 6 5 9
FIX 1
FIX 2
FIX 5 1 2 3
DYNE 1
RLSE 2 1
DYNE 3 1
RLSE 6 1
END
HALT
ESTIFF 1 100 200 300 400 0.3 0.2
ESTIFF 2 10
ESTIFF 3 6
EDAMP 1 1 2 3 4
EM 1 2 0.5 0.2 0.3
ESIG 1 0 0 5 0 0 0
XM 7 4
XM 6 1 0 0 2 0 3
XF 7 1 2 3
XF 4 0.5 0.25 0.125
XF 6 0 2 4 6
END
HALT
INPUTF 1 7 3
OUTX 1 7 3
END
END
)");
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  expect_in_scene("EA: 100, GJ: 200, EI_y: 300,");
  expect_in_scene("EI_z: 400, shear_y: 2000, shear_z: 1000,");
  expect_in_scene(
      "damping: [[1, 0, 0, 0, 0, 0], [0, 2, 0, 0, 0, 0], [0, 0, 12, -6, 0, 0], [0, 0, -6, 12, 0, "
      "0], [0, 0, 0, 0, 16, -8], [0, 0, 0, 0, -8, 16]]");
  expect_in_scene("preload: [0, 0, 5, 0, 0, 0]");
  expect_in_scene("e3: {type: hinge, nodes: [n3r4, n3], axis: [0, 0, 1], rigid: [2, 3]");
  expect_in_scene("e4: {type: rigid_beam, nodes: [n3, n7]}");
  expect_in_scene("e5: {type: rigid_beam, nodes: [n7, n9]}");
  expect_in_scene("{node: n3r4, torque: [0.5, 0.25, 0.125]}");
  expect_in_scene("{node: n3, torque: [1, 2, 3]}");
  EXPECT_EQ(run({"modes", folder_ / "scene.yaml"}).exit_code, 0)
      << run({"modes", folder_ / "scene.yaml"}).error;
}

TEST_F(ImportVerb, EveryFieldOfLight) {
  // Strips that warp into each other, and nothing else, are left out.
  const ImportedJson document = imported("all.m", R"(function out = all(p)
%{
what is in here is no code [
%}
a = 2 * 3^2 / 9;  b = [1, 2 ...  continued
     3]'; c = linspace(0, 1, 3);
d.length = a/4;   % 0.5
nodes = [0 0 0
         d.length -0 c(2)-0.5   % a row
         1 0 0; 1 0 0
         b(1) +1 0; sind(90)*2, 0, 0; 0.5, max(b)-2, 0];
elements = [1 2; 2 3; 3 4; 4 5; 3 6; 5 7];
nprops(1).fix = true;  nprops(2).fix_x = false;
nprops(5).fix_pos = 1; nprops(5).fix_orien = true;
nprops(6).fix_y = true; nprops(6).fix_z = true;
nprops(6).displ_initial_x = -0.25;
nprops(6).displ_x = 0.75;
nprops(2).force = [0 1 0]; nprops(2).force_initial = [1 0 0];
nprops(2).moment = [0 0 1]; nprops(2).moment_initial = [0 0 -0.5];
nprops(2).mass = 3;
nprops(2).mominertia = [1 0 0 2 0 2.5];
nprops(2).transfer_in = {'force_x', 'force_z'};
nprops(2).transfer_out = "displ_y"; nprops(7).transfer_out = {'veloc_z'};
nprops(7).fix_warp = true;
eprops(1).elems = [1 2]; eprops(1).emod = 2e6; eprops(1).smod = 1e6; eprops(1).dens = 10;
eprops(1).cshape = 'rect'; eprops(1).dim = [0.1 0.01]; eprops(1).orien = [0 0 1];
eprops(1).nbeams = 3; eprops(1).flex = [2 3 4]; eprops(1).color = 'grey'; eprops(1).hide = true;
eprops(1).opacity = 0.5;
eprops(2).elems = 3; eprops(2).type = 'hinge'; eprops(2).orien = [0 1 0];
eprops(3).elems = [4 6]; eprops(3).emod = 2e6; eprops(3).smod = 1e6; eprops(3).dens = 10;
eprops(3).cshape = 'rect'; eprops(3).dim = [0.1 0.01]; eprops(3).orien = [0 0 1];
eprops(3).flex = 1:6; eprops(3).warping = true;
eprops(4).elems = 5; eprops(4).emod = 2e6; eprops(4).smod = 1e6; eprops(4).dens = 10;
eprops(4).cshape = 'circ'; eprops(4).dim = 0.02; eprops(4).orien = [0 0 1]; eprops(4).flex = 1:6;
opt.gravity = [0 0 -9.81]; opt.filename = 'x'; opt.loadsteps = 5; opt.transfer = {true, 0.01};
opt.rls(2).def = 1;
opt.calcbuck = true;
out = spacarlight(nodes, elements, nprops, eprops, opt);
end
)",
                                         4);
  EXPECT_EQ(document["left_out"].size(), 2u) << document["left_out"];
  for (const auto& remark : document["left_out"]) {
    EXPECT_EQ(remark["what"], "eprops(3).warping");
  }
  EXPECT_TRUE(document["approximated"].empty()) << document["approximated"];
  expect_in_scene("modal_damping: 0.01 ");
  expect_in_scene("n2: {position: [0.5, 0, 0]}");
  expect_in_scene("n5: {position: [1, 1, 0]}");
  expect_in_scene("n6: {position: [2, 0, 0]}");
  expect_in_scene("n7: {position: [0.5, 1, 0]}");
  expect_in_scene("rigid: [1, 5, 6], second_order: true");
  // A release of what is not flexible is in the last beam of an element alone.
  expect_in_scene("e2: {type: beam, nodes: [n2, e2_last]");
  expect_in_scene("e2_last: {type: beam, nodes: [e2_last, n3]");
  expect_in_scene("rigid: [5, 6],\n    second_order: true}");
  expect_in_scene("e3: {type: hinge, nodes: [n3, n4], axis: [0, 1, 0], rigid: [2, 3]}");
  expect_in_scene("{node: n2, force: [1, 1, 0], torque: [0, 0, 0.5]}");
  expect_in_scene("{nodes: [n6], move: [x], value: 0.5}");
  expect_in_scene("{nodes: [n6], fix: [y, z]}");
  expect_in_scene("{nodes: [n5], fix: [x, y, z, rotation]}");
  expect_in_scene("{name: force_z_n2, force: n2, along: z}");
  expect_in_scene("{name: veloc_z_n7, velocity: n7, along: z}");
}

// --- what MATLAB makes of a function

TEST_F(ImportVerb, FunctionsAreThoseOfMatlab) {
  // Three numbers that MATLAB makes of an expression; they are the force on the tip.
  const std::vector<std::array<std::string, 2>> cases{
      {"[sum([1 2; 3 5]) 1]", "[4, 7, 1]"},
      {"[sum([1 2; 3 5], 1) 1]", "[4, 7, 1]"},
      {"[sum([1 2; 3 5], 2)' 1]", "[3, 8, 1]"},
      {"sum([1 2 3])*[1 0 0] + [0 sum([4; 5]) 0] + [0 0 sum([1 2; 3 5], 'all')]", "[6, 9, 11]"},
      {"sum([1 2 3], 1)", "[1, 2, 3]"},
      {"[sum([]) sum([1; 2], 2)']", "[0, 1, 2]"},
      {"[max([1 5; 3 2]) 1]", "[3, 5, 1]"},
      {"[min([1 5; 3 2]) 1]", "[1, 2, 1]"},
      {"[max([1 5; 3 2], [], 2)' 1]", "[5, 3, 1]"},
      {"[min([1 5; 3 2], [], 1) max([1 5; 3 2], [], 'all')]", "[1, 2, 5]"},
      {"max([1 5 3], [2 4 3])", "[2, 5, 3]"},
      {"min([1 5 3], 2)", "[1, 2, 2]"},
      {"[max([3 9]) min([3; 9]) max(2, 4)]", "[9, 3, 4]"},
      {"[norm([3 -4]) norm([3 -4], 1) norm([3; -4], 2)]", "[5, 7, 5]"},
      {"cross([1 0 0]', [0 1 0]')' + cross([0 1 0], [0 0 1])", "[1, 0, 1]"},
      {"atan2([0 0 0], [1 1 1]) + [1 2 3]", "[1, 2, 3]"},
      // Powers and transposes bind alike, so this column is (x.^2)'.
      {"sum([1 2 3].^2', 2)'", "[1, 4, 9]"},
      {"[round(-2.5) floor(-2.5) ceil(-2.5)]", "[-3, -3, -2]"},
      {"linspace(1, 3, 3)", "[1, 2, 3]"},
      {"[length([1 2; 3 4; 5 6]) numel([1 2; 3 4]) 1]", "[3, 4, 1]"}};
  for (const auto& [expression, result] : cases) {
    const ImportedJson document =
        imported("f.m", replaced(cantilever_m, "mass = 0.05", "force = " + expression));
    EXPECT_TRUE(document["left_out"].empty()) << expression << document["left_out"];
    EXPECT_NE(scene().find("{node: n2, force: " + result + "}"), std::string::npos)
        << expression << "\n"
        << scene();
  }
}

TEST_F(ImportVerb, ArgumentsThatAFunctionHasNotAreNamed) {
  const std::vector<std::array<std::string, 2>> cases{
      {"round(1.26, 1)", "round: found 2 arguments, allowed is 1"},
      {"abs(1, 2)", "abs: found 2 arguments, allowed is 1"},
      {"sum([1 2], 1, 2)", "sum: found 3 arguments, allowed are 1 to 2"},
      {"sum([1 2], 3)", "sum: found dimension 3, allowed are 1, 2 and 'all'"},
      {"sum([1 2], 'omitnan')", "sum: found another word for a dimension"},
      {"max([1 2], 1, 2)", "max: found 3 arguments, allowed are one, two, or"},
      {"max([1 2], [1 2 3])", "max: found matrices of two sizes"},
      {"norm([1 2; 3 4])", "norm: found a matrix, allowed is a vector"},
      {"norm([1 2], 3)", "norm: found another norm, allowed are 1 and 2"},
      {"linspace(1, 2, 3, 4)", "linspace: found 4 arguments, allowed are 2 to 3"},
      {"linspace(1, 2, 2.5)", "linspace: found size 2.5"},
      {"zeros(1, 2, 3)", "zeros: found 3 arguments, allowed are 0 to 2"},
      {"ones(1.5)", "ones: found size 1.5"},
      {"cross([1 0 0], [0 1 0]')", "cross: found other matrices"},
      {"cross([1 0 0], [0 1 0], 2)", "cross: found 3 arguments, allowed are 2"},
      {"length([1 2], 1)", "length: found 2 arguments, allowed is 1"},
      {"numel([1 2], 1)", "numel: found 2 arguments, allowed is 1"},
      {"atan2(1)", "atan2: found 1 argument, allowed are 2"},
      {"min(3, sqrt(-1))", "sqrt: found -1, allowed is what has a real value"},
      {"min(3, (-8)^(1/3))", "a power of a negative number has no real value"},
      {"max(1 2)", "there is no ')'"},
      {"['a' 1]", "a text stands in a matrix"},
      {"['a'; 'b']", "a text stands in a matrix"}};
  for (const auto& [expression, why] : cases) {
    const std::string line = "q = " + expression + ";";
    const Said said =
        run({"import", write("f.m", replaced(cantilever_m, "nprops(2).mass = 0.05;", line)),
             "--out", folder_ / "f.yaml"});
    EXPECT_EQ(said.exit_code, 4) << line << said.error;
    EXPECT_NE(said.output.find("line 7: " + line + ": " + why), std::string::npos) << line << "\n"
                                                                                   << said.output;
  }
}

TEST_F(ImportVerb, ClearEndsVariables) {
  const auto after = [&](const std::string& lines) {
    return replaced(cantilever_m, "eprops(1).elems", lines + "\neprops(1).elems");
  };
  const auto says = [&](const std::string& lines, const std::string& what) {
    const Said said = run({"import", write("c.m", after(lines)), "--out", folder_ / "scene.yaml"});
    EXPECT_EQ(said.exit_code, 4) << lines << said.error;
    EXPECT_NE(said.output.find(what), std::string::npos) << lines << "\n" << said.output;
  };
  // Fields of a structure, and what other names there are stays.
  for (const char* line : {"clear nprops", "clearvars nprops", "clear('nprops')", "clear nprops L",
                           "clearvars -except L t nodes elements"}) {
    const ImportedJson document =
        imported("c.m", after(std::string(line) + "\nnprops(1).fix = true;"));
    EXPECT_TRUE(document["left_out"].empty()) << line << document["left_out"];
    EXPECT_EQ(scene().find("mass: 0.05"), std::string::npos) << line << "\n" << scene();
    expect_in_scene("{nodes: [n1], fix: [x, y, z, rotation]}");
  }
  for (const char* line : {"clear functions", "clear L", "clearvars L"}) {
    imported("c.m", after(line));
    expect_in_scene("{node: n2, mass: 0.05");
  }
  says("clear L\nnprops(2).force = [L 0 0];", "line 9: nprops(2).force = [L 0 0];: 'L' is not");
  says("clear L*", "line 8: clear L*: is read with names of variables alone");
  says("clear all L", "line 8: clear all L: is read with names");
  says("clear global", "line 8: clear global: is read with names");
  says("clear -regexp ^L", "line 8: clear -regexp ^L: is read with names");
  says("if 1\nclear L\nend\nnprops(2).force = [L 0 0];", "line 11: nprops(2).force = [L 0 0];:");
  says("return", "line 8: return: ");
  for (const char* line : {"clear", "clearvars", "clear all", "clear variables", "clear nodes"}) {
    expect_bad("c.m", after(line), "nodes: found no value of it");
  }
}

TEST_F(ImportVerb, WhatIsSetInPartOrInABlockIsNotKnown) {
  const auto says = [&](const std::string& lines, const std::string& what) {
    const Said said =
        run({"import", write("p.m", replaced(cantilever_m, "nprops(2).mass = 0.05;", lines)),
             "--out", folder_ / "scene.yaml"});
    EXPECT_EQ(said.exit_code, 4) << lines << said.error;
    EXPECT_NE(said.output.find(what), std::string::npos) << lines << "\n" << said.output;
  };
  const std::string use = "\nnprops(2).force = [q 0 0];", unknown = "'q' is not known";
  says("p.v = [1 2 3];\np.v(2) = 9;\nnprops(2).force = p.v;", "line 8: p.v(2) = 9;: a part of");
  says("p.v = [1 2 3];\np.v(2) = 9;\nnprops(2).force = p.v;", "line 9: nprops(2).force = p.v;: ");
  says("q = 1;\nfor q = 1:3\nend" + use, unknown);
  says("q = 1;\nfor (q = 1:3)\nend" + use, unknown);
  says("q = 1;\nif 1\n[q, w] = size(3);\nend" + use, unknown);
  says("q = 1;\nif 1 q = 2;\nend" + use, unknown);
  says("q = 1;\nif 1\nelse q = 2;\nend" + use, unknown);
  says("eprops(1).type = 'wire';", "line 7: eprops(1).type: is a type that is read as a beam");
  says("opt = 3;\nout = spacarlight(nodes, elements, nprops, opt);",
       "line 7: opt: is no structure");
  // A field that is set anew has nothing of its former parts.
  std::string text =
      replaced(cantilever_m, "nprops(2).mass = 0.05;", "opt.rls(1).def = 1;\nopt.rls = [];");
  text = replaced(replaced(text, "1:6;", "2:6;"), "eprops);", "eprops, opt);");
  const ImportedJson document = imported("p.m", text);
  EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
  expect_in_scene("rigid: [1]");
  const ImportedJson round =
      imported("p.m", replaced(replaced(cantilever_m, "'rect'", "'circ'"), "[20*t t]", "[t t]"));
  ASSERT_EQ(round["approximated"].size(), 1u);
  EXPECT_EQ(round["approximated"][0]["what"], "eprops(1).dim");
  expect_bad("p.m", replaced(cantilever_m, "nbeams = 4", "nbeams = [4 5]"),
             "eprops(1).nbeams: found 2 numbers, allowed is one number");
}

/// DELINPX is added to what is prescribed, on whichever side of INPUTX it stands.
TEST_F(ImportVerb, StepsAreAddedBeforeAndBehindWhatTheyAreAddedTo) {
  const std::string text = R"(PLTRUSS 1 1 2
PLTRUSS 2 2 3
X 1 0 0
X 2 1 0
X 3 2 0
FIX 1
FIX 2 2
FIX 3 2
INPUTX 3 1
INPUTE 1 1
END
HALT
)";
  const std::string x = "INPUTX 3 1 2.25 0 0\n", dx = "DELINPX 3 1 0.5\n", e = "INPUTE 1 1 0.125\n",
                    de = "DELINPE 1 1 0.0625\n";
  for (const std::string& lines :
       {x + dx + e + de, dx + x + de + e, dx + de + x + e, de + e + x + dx}) {
    const ImportedJson document = imported("d.dat", text + lines + "END\nEND\n");
    EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
    expect_in_scene("{nodes: [n3], move: [x], value: 0.75}");
    expect_in_scene("{element: e1, mode: 1, value: 0.1875}");
  }
  expect_bad("d.dat", text + x + x + "END\nEND\n",
             "d.dat:14: INPUTX: found a second line for 3 1, allowed is one for each");
  expect_bad("d.dat", text + "GRAVITY 0 1\nGRAVITY 1 0\nEND\nEND\n",
             "d.dat:14: GRAVITY: found a second line");
  expect_bad("d.dat", text + "XF 2 1 0\nXF 2 2 0\nEND\nEND\n",
             "d.dat:14: XF: found a second line for node 2");
  expect_bad("d.dat", text + "XM 2 1\nXM 2 2\nEND\nEND\n",
             "d.dat:14: XM: found a second line for node 2");
  expect_bad("d.dat", text + "STARTDE 1\nEND\nEND\n", "d.dat:13: STARTDE: found 1 number");
  expect_bad("d.dat", text + "END 3\nEND\n", "d.dat:13: END: found '3' behind it");
  expect_bad("d.dat", replaced(text, "INPUTX 3 1", "DYNX 3 4") + "END\nEND\n",
             "d.dat:9: DYNX: found coordinate 4");
}

TEST_F(ImportVerb, NumbersOfWarpingOfAPlainBeamAreNamed) {
  for (const char* line : {"ESTIFF 1 100 200 300 400 0 0 5", "EM 1 2 0.5 0.2 0.3 0 0.1"}) {
    const std::string kinematics =
        "BEAM 1 1 2 3 4 0 1 0\nX 1 0 0 0\nX 3 1 0 0\nFIX 1\nFIX 2\nDYNE 1\nEND\nHALT\n";
    const ImportedJson document = imported("w.dat", kinematics + line + "\nXM 3 1\nEND\nEND\n");
    EXPECT_TRUE(document["left_out"].empty()) << document["left_out"];
    ASSERT_EQ(document["no_part"].size(), 1u) << line;
    EXPECT_EQ(document["no_part"][0]["line"], 9);
    const std::string why = document["no_part"][0]["why"];
    EXPECT_NE(why.find("is of warping, and a BEAMW alone warps"), std::string::npos) << why;
  }
}

// --- what is left out

TEST_F(ImportVerb, WhatIsLeftOutIsNamedWithItsLine) {
  const std::string text =
      replaced(leaf_guide_dat, "INPUTX 7 1\n", "INPUTX 8 4\nWHEEL 9 4 5 7\nDYNE 9 1\nKINX 4 1\n");
  const auto file = write("left.dat", text);
  const auto out = folder_ / "left.yaml";
  const Said said = run({"import", file, "--out", out});
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_EQ(said.error, "");
  for (const char* line : {"line 17: INPUTX 8 4: ", "line 18: WHEEL 9 4 5 7: a scene has no such",
                           "line 19: DYNE 9 1: belongs to element 9", "line 20: KINX 4 1: "}) {
    EXPECT_NE(said.output.find(line), std::string::npos) << line << "\n" << said.output;
    EXPECT_NE(text_of(out).find(line), std::string::npos) << line;
  }
  const Said as_json = run({"import", file, "--out", out, "--json"});
  EXPECT_EQ(as_json.exit_code, 4);
  EXPECT_EQ(ImportedJson::parse(as_json.output)["left_out"].size(), 4u);
}

TEST_F(ImportVerb, WhatOfAScriptIsNotRunIsNamedWithItsLine) {
  std::string text = replaced(cantilever_m, "nprops(2).mass",
                              "for i = 1:2\n  q = i;\n  if i > 1, q = 2; end\nend\n"
                              "nprops(2).rot_z = 0.1;\nnprops(2).force = [q 0 0];\n"
                              "nodes2(3, :) = 1;\nnprops(2).mass");
  text = replaced(text, "out = spac",
                  "eprops(1).strange = 1; opt.transfer = {true -0.01};\nout = spac");
  text = replaced(text, "eprops);", "eprops, opt);");
  const Said said = run({"import", write("left.m", text), "--out", folder_ / "left.yaml"});
  EXPECT_EQ(said.exit_code, 4) << said.error;
  for (const char* line :
       {"line 7: for i = 1:2: loops", "line 11: nprops(2).rot_z: ",
        "line 12: nprops(2).force = [q 0 0];: 'q' is not known", "line 13: nodes2(3, :) = 1;: ",
        "line 24: eprops(1).strange: ", "line 24: opt.transfer: gives each mode"}) {
    EXPECT_NE(said.output.find(line), std::string::npos) << line << "\n" << said.output;
  }
}

TEST_F(ImportVerb, TakesWhatAScriptHasFromElsewhere) {
  std::string text = replaced(cantilever_m, "nprops(2).mass", "nprops(2).mass = p.load(2).m; %");
  text = replaced(text, "out = spac", "opt.transfer = {true, p.zeta};\nout = spac");
  text = replaced(text, "clear, clc", "");  // which would end p, too
  text = "function out = model(p)\n" + replaced(text, "eprops);", "eprops, opt);");
  const std::filesystem::path file = write("argument.m", text), out = folder_ / "argument.yaml";
  const Said without = run({"import", file, "--out", out});
  EXPECT_EQ(without.exit_code, 4);
  EXPECT_NE(without.output.find("'p.load(2).m' is not known; --set p.load(2).m=VALUE says it"),
            std::string::npos)
      << without.output;
  const Said with =
      run({"import", "--set", "p.load(2).m=3/2", "--set", "p.zeta=1e-2", file, "--out", out});
  EXPECT_EQ(with.exit_code, 0) << with.output << with.error;
  const std::string scene = text_of(out);
  EXPECT_NE(scene.find("mass: 1.5,"), std::string::npos) << scene;
  EXPECT_NE(scene.find("modal_damping: 0.01 "), std::string::npos) << scene;
  EXPECT_NE(scene.find("# Given: --set p.load(2).m=3/2"), std::string::npos) << scene;
  for (const auto& [given, said] :
       {std::pair{"p.zeta", "found no assignment, allowed is one, NAME=VALUE"},
        {"for=1", "found no assignment, allowed is one, NAME=VALUE"},
        {"q=1", "nothing in "},
        {"t=2", "the script says 't' itself, in line 4"},
        {"nprops=1", "the script says 'nprops(1).fix' itself, in line "},
        {"eprops(1).dens=3", "the script says 'eprops(1).dens' itself, in line "},
        {"dens=3", "nothing in "},
        {"p.zeta=foo(1)", "'foo' is not known"},
        {"p.zeta=", ""}}) {
    const Said wrong = run({"import", "--set", given, file, "--out", out});
    EXPECT_EQ(wrong.exit_code, 2) << given << wrong.output;
    EXPECT_NE(wrong.error.find(std::string("--set ") + given + ": " + said), std::string::npos)
        << wrong.error;
  }
}

TEST_F(ImportVerb, ModalDampingIsAskedForByBothCells) {
  std::string text =
      replaced(cantilever_m, "out = spac", "opt.transfer = {false, 0.01};\nout = spac");
  text = replaced(text, "eprops);", "eprops, opt);");
  const std::filesystem::path file = write("not_asked.m", text), out = folder_ / "not_asked.yaml";
  EXPECT_EQ(run({"import", file, "--out", out}).exit_code, 0);
  EXPECT_EQ(text_of(out).find("modal_damping"), std::string::npos);
  const Said cleared =
      run({"import", "--set", "p.m=1", write("clears.m", replaced(cantilever_m, "0.05", "p.m")),
           "--out", out});
  EXPECT_EQ(cleared.exit_code, 2);
  EXPECT_NE(cleared.error.find("--set p.m=1: the script clears it, in line 2"), std::string::npos)
      << cleared.error;
}

// --- relations

TEST_F(ImportVerb, CaseTabsAndLineEndsDoNotMatter) {
  imported("guide.dat", leaf_guide_dat);
  const std::string as_is = scene();
  std::string other;
  for (const char c : std::string(leaf_guide_dat)) {
    other += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  other = replaced_everywhere(replaced_everywhere(other, ' ', " \t "), '\n', " % x\r\n");
  imported("guide.dat", other);
  EXPECT_EQ(scene(), as_is);
  imported("guide.dat", replaced_everywhere(leaf_guide_dat, '\n', "\r"));
  EXPECT_EQ(scene(), as_is);
}

/// Frames of random beams between random nodes: numbers are names, lines of a block have no order.
TEST_F(ImportVerb, NumbersAndOrderOfLinesDoNotMatter) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0.1, 1);
  for (int round = 0; round < 5; ++round) {
    const int n = 4;
    std::vector<int> number(2 * n);
    std::iota(number.begin(), number.end(), 1);
    std::vector<std::array<double, 3>> at;
    for (int i = 0; i < n; ++i) at.push_back({i + part(random), part(random), part(random)});
    std::vector<std::string> values;
    for (int i = 0; i + 1 < n; ++i) {
      std::string of;
      for (int k = 0; k < 4; ++k) of += " " + std::to_string(100 * part(random));
      values.push_back(of);
    }
    std::vector<double> first;
    for (int turn = 0; turn < 2; ++turn) {
      const auto p = [&](int i) { return std::to_string(number[2 * i]); };
      const auto r = [&](int i) { return std::to_string(number[2 * i + 1]); };
      std::vector<std::string> kinematics, dynamics;
      for (int i = 0; i < n; ++i) {
        kinematics.push_back("X " + p(i) + " " + std::to_string(at[i][0]) + " " +
                             std::to_string(at[i][1]) + " " + std::to_string(at[i][2]));
        dynamics.push_back("XM " + p(i) + " 2");
        dynamics.push_back("XM " + r(i) + " 1 0 0 1 0 1");
      }
      for (int i = 0; i + 1 < n; ++i) {
        const std::string e = std::to_string(turn == 0 ? i + 1 : 90 - i);
        kinematics.push_back("BEAM " + e + " " + p(i) + " " + r(i) + " " + p(i + 1) + " " +
                             r(i + 1) + " 0 0.3 1");
        kinematics.push_back("DYNE " + e);
        dynamics.push_back("ESTIFF " + e + values[i]);
      }
      kinematics.push_back("FIX " + p(0));
      kinematics.push_back("FIX " + r(0));
      if (turn == 1) {
        std::shuffle(kinematics.begin(), kinematics.end(), random);
        std::shuffle(dynamics.begin(), dynamics.end(), random);
      }
      std::string text;
      for (const auto& line : kinematics) text += line + "\n";
      text += "END\nHALT\n";
      for (const auto& line : dynamics) text += line + "\n";
      imported("random.dat", text + "END\nEND\n");
      const std::vector<double> hz = frequencies(folder_ / "scene.yaml");
      if (turn == 0) {
        first = hz;
        std::shuffle(number.begin(), number.end(), random);
        continue;
      }
      ASSERT_EQ(hz.size(), first.size());
      // Other nodes are eliminated first: rounding of a spectrum over three decades.
      for (std::size_t i = 0; i < hz.size(); ++i) EXPECT_NEAR(hz[i] / first[i], 1, 1e-9);
    }
  }
}

// --- what cannot be read

TEST_F(ImportVerb, BadDatFilesAreRefusedWithTheirLine) {
  const std::string good = leaf_guide_dat;
  const auto with = [&](const std::string& what, const std::string& by) {
    return replaced(good, what, by);
  };
  expect_bad("a.dat", "", "a.dat: is empty");
  expect_bad("a.dat", " \n\t\n", "a.dat: is empty");
  expect_bad("a.dat", with("END\nEND\n", ""), "a.dat:26: END: found the end of the file");
  expect_bad("a.dat", with("END\nEND\n", "END\n"), "found the end of the file after 1 END");
  expect_bad("a.dat", with("END\nHALT\n", "HALT\n"), "a.dat:18: HALT: found without an END");
  expect_bad("a.dat", with("END\nHALT\n", "END\n"), "a.dat:19: ESTIFF: found after one END");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 4 0 0.1"),
             "a.dat:3: X: found 3 numbers, allowed are a node, x, y and z");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 1 0 0.1 0"), "a.dat:3: X: found node 1 a second time");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 4 0 nan 0"), "a.dat:3: X: found 'nan'");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 4 0 inf 0"), "a.dat:3: X: found 'inf'");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 4 0 1e31 0"), "a.dat:3: X: found '1e31'");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 4.5 0 0.1 0"), "a.dat:3: X: found '4.5'");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X -4 0 0.1 0"), "a.dat:3: X: found '-4'");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 99999999999999999999 0 0 0"),
             "a.dat:3: X: found '999");
  expect_bad("a.dat", with("X 4 0 0.1 0", "X 4 0 0 0"), "a.dat:6: BEAM: found two nodes at one");
  expect_bad("a.dat", with("BEAM 3 4 5", "BEAM 3 44 5"), "a.dat:8: BEAM: found node 44, which has");
  expect_bad("a.dat", with("BEAM 3 4 5", "BEAM 2 4 5"), "a.dat:8: BEAM: found element 2 a second");
  expect_bad("a.dat", with("BEAM 3 4 5", "BEAM 3 4 7"), "a.dat:8: BEAM: found node 7 as an");
  expect_bad("a.dat", with("BEAM 3 4 5 7 8 0 0 1", "BEAM 3 4 5 7"),
             "a.dat:8: BEAM: found 4 numbers");
  expect_bad("a.dat", with("BEAM 3 4 5 7 8 0 0 1", "BEAM 3 4 5 7 8 0 0 0"),
             "direction of zero length");
  expect_bad("a.dat", with("BEAM 3 4 5 7 8 0 0 1", "PLBEAM 3 4 5 7 8"),
             "a.dat:8: PLBEAM: found beside BEAM of line 7");
  expect_bad("a.dat", with("BEAM 3 4 5 7 8 0 0 1", "BEAM 3 4 5 7 8 1 0 0"), "makes no sound scene");
  expect_bad("a.dat", with("DYNE 1 4 6", "DYNE 1 4 7"), "a.dat:9: DYNE: found deformation 7");
  expect_bad("a.dat", with("DYNE 1 4 6", "DYNE 7 4"), "a.dat:9: DYNE: found element 7");
  expect_bad("a.dat", with("DYNE 1 4 6", "DYNE"), "a.dat:9: DYNE: found 0 numbers");
  expect_bad("a.dat", with("FIX 1 1 2 3", "FIX 1 1 2 4"), "a.dat:13: FIX: found coordinate 4");
  expect_bad("a.dat", with("FIX 1 1 2 3", "FIX 77"), "a.dat:13: FIX: found node 77");
  expect_bad("a.dat", with("XM 7 0.1", "XM 7 -0.1"), "XM: found a negative number");
  expect_bad("a.dat", with("XM 7 0.1", "XM 7 0.1 2"), "XM: found 3 numbers");
  expect_bad("a.dat", with("ESTIFF 2", "ESTIFF 1"), "ESTIFF: found a second line for e1");
  expect_bad("a.dat", with("ESTIFF 2", "ESTIFF 2 -1"), "ESTIFF: found a negative number");
  expect_bad("a.dat", "X 1 0 0\nEND\nEND\n", "a.dat:1: elements: found none");
  expect_bad("a.dat", with("X 4", std::string("\x01 X 4")),
             "a.dat:3: line: found a control character");
  expect_bad("a.txt", good, "a.txt: found a file of another name");
  expect_refused({"import", folder_ / "none.dat"}, 2, "none.dat: cannot be read");
  expect_refused({"import", folder_}, 2, "found a file of another name");
  const auto same = write("same.dat", good);
  expect_refused({"import", same, "--out", same}, 2, "is the file that is read");
  EXPECT_EQ(text_of(same), good);
}

TEST_F(ImportVerb, BadScriptsAreRefusedWithTheirLine) {
  const auto with = [&](const std::string& what, const std::string& by) {
    return replaced(cantilever_m, what, by);
  };
  expect_bad("a.m", "x = 1;\n", "a.m:1: script: found no call of spacarlight");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0 0; L 0 0"), "bracket that");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0 0; L 0 0))"), "a.m:4: )");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0 0; L 0]"),
             "a.m:4: nodes: found what is not worked");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0; L 0]"), "a.m:4: nodes: found 2 rows of 2");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0 0; M 0 0]"), "'M' is not known");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0 0; L/0 0 0]"), "that is not finite");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "[0 0 0; 0 0 0]"), "between nodes at one position");
  expect_bad("a.m", with("[0 0 0; L 0 0]", "'text'"), "a.m:4: nodes: found a text");
  expect_bad("a.m", with("[1 2];", "[1 3];"),
             "a.m:5: elements: found node 3, allowed is a node from");
  expect_bad("a.m", with("[1 2];", "[1 1.5];"), "a.m:5: elements: found node 1.5");
  expect_bad("a.m", with("nprops(2)", "nprops(3)"), "a.m:7: nprops(3).mass: found node 3");
  expect_bad("a.m", with("0.05", "-0.05"), "a.m:7: nprops(2).mass: found -0.05");
  expect_bad("a.m", with("0.05", "[1 2]"), "a.m:7: nprops(2).mass: found 2 numbers");
  expect_bad("a.m", with("0.05", "'x'"), "a.m:7: nprops(2).mass: found a text");
  expect_bad("a.m", with("elems = 1", "elems = 2"), "a.m:8: eprops(1).elems: found 2, allowed is");
  expect_bad("a.m", with("'rect'", "'round'"),
             "eprops(1).cshape: found 'round', allowed are 'rect'");
  expect_bad("a.m", with("'rect'", "'rect"), "a.m:12: ': found no end of the text");
  expect_bad("a.m", with("[20*t t]", "t"), "eprops(1).dim: found 1 number, allowed are 2 numbers");
  expect_bad("a.m", with("[20*t t]", "[20*t -t]"), "eprops(1).dim: found -0.001");
  expect_bad("a.m", with("[0 0 1];", "[1 0 0];"), "eprops(1).orien: found a direction along e1");
  expect_bad("a.m", with("1:6", "1:7"), "eprops(1).flex: found 7, allowed is a deformation from 1");
  expect_bad("a.m", with("nbeams = 4", "nbeams = 0"), "eprops(1).nbeams: found 0");
  expect_bad("a.m", with("eprops(1).smod = 70e9;\n", ""), "a.m:8: eprops(1): found no smod");
  expect_bad("a.m", with("210e9", "210e999"), "a.m:9: number: found '210e999'");
  expect_bad("a.m", with("nprops, eprops)", "nprops)"), "found 3 arguments");
  expect_bad("a.m", with("nprops, eprops)", "nprops, eprops, a, b, c)"), "found 7 arguments");
}

TEST_F(ImportVerb, HugeFilesAreRefusedQuickly) {
  std::ofstream(folder_ / "long.dat") << "X 1 " << std::string(std::size_t{100} << 20, '1') << "\n";
  expect_refused({"import", folder_ / "long.dat"}, 2, "long.dat: found more than 16 MiB");
  expect_bad("line.dat", "X 1 " + std::string(20000, '1') + "\nEND\nEND\n",
             "line.dat:1: line: found 20004 bytes, allowed 10000 at most");
  std::string doubled = "a = ones(100);\n";
  for (int k = 0; k < 40; ++k) doubled += "a = [a a; a a];\n";
  expect_bad("large.m", doubled + "nodes = a;\nspacarlight(nodes, nodes, a, a);\n",
             "large.m:42: nodes: found what is not worked out: 'a' is not known");
  expect_bad("deep.m", "a = " + std::string(5000, '(') + "1" + std::string(4000, ')') + ";\n",
             "deep.m:");
}

}  // namespace
}  // namespace stillframe::test
