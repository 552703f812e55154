#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/yaml/formula.hpp"
#include "core/yaml/load.hpp"
#include "core/yaml/turned.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

const FormulaNames no_names{[](const std::string&) { return std::nullopt; },
                            [](std::size_t) { return std::nullopt; }};

/// A formula of random shape, in as few brackets as it needs or more, and its value.
struct Grown {
  std::string text;
  double value;
  int rank;  ///< 0: a sum; 1: a product; 2: a sign; 3: a power; 4: one piece
};

Grown grown(std::mt19937& engine, int depth) {
  const auto below = [&](int n) { return static_cast<int>(engine() % static_cast<unsigned>(n)); };
  const auto within = [&](int rank) {
    Grown part = grown(engine, depth - 1);
    if (part.rank < rank || below(4) == 0) part = {"(" + part.text + ")", part.value, 4};
    return part;
  };
  const std::string space = below(2) == 0 ? "" : " ";
  const auto joined = [&](const Grown& a, char sign, const Grown& b) {
    return a.text + space + sign + space + b.text;
  };
  switch (depth == 0 ? 0 : below(7)) {
    case 1: {
      const Grown a = within(0), b = within(1);
      return {joined(a, '+', b), a.value + b.value, 0};
    }
    case 2: {
      const Grown a = within(0), b = within(1);
      return {joined(a, '-', b), a.value - b.value, 0};
    }
    case 3: {
      const Grown a = within(1), b = within(2);
      return {joined(a, '*', b), a.value * b.value, 1};
    }
    case 4: {
      const Grown a = within(1), b = within(2);
      return {joined(a, '/', b), a.value / b.value, 1};
    }
    case 5: {
      const Grown a = within(2);
      return {"-" + a.text, -a.value, 2};
    }
    case 6: {
      const Grown a = grown(engine, depth - 1);
      return {"cos(" + a.text + ")", std::cos(a.value), 4};
    }
    default: {
      const double number = below(1000) / 8.0 + 0.125;
      std::ostringstream text;
      text << number;
      return {text.str(), number, 4};
    }
  }
}

TEST(Shorthand, RandomFormulasAreWhatTheyAreMadeOf) {
  std::mt19937 engine(1);
  int n = 0;
  for (int i = 0; i < 20000; ++i) {
    const Grown formula = grown(engine, 5);
    if (!std::isfinite(formula.value) || formula.text.size() > 400) continue;
    ++n;
    // The same operations in the same order: the same bits.
    ASSERT_EQ(evaluate(formula.text, no_names), formula.value) << formula.text;
  }
  EXPECT_GT(n, 15000);
}

TEST(Shorthand, FormulasReadAsOnPaper) {
  EXPECT_EQ(evaluate("-2^2", no_names), -4);
  EXPECT_EQ(evaluate("2^-1", no_names), 0.5);
  EXPECT_EQ(evaluate("2^3^2", no_names), 512);
  EXPECT_EQ(evaluate("8/2*4 - 3 - 2", no_names), 11);
  EXPECT_EQ(evaluate("1e3 + .5 + 2.5e-1", no_names), 1000.75);
  EXPECT_EQ(evaluate("90*deg", no_names), std::numbers::pi / 2);
  EXPECT_EQ(evaluate("sqrt(3)/2 + abs(-1) + log(exp(0))", no_names), std::sqrt(3.0) / 2 + 1);
}

Scene documented_frame() {
  std::ifstream file(STILLFRAME_SOURCE_DIR "/docs/scene.md");
  std::stringstream stream;
  stream << file.rdbuf();
  const std::string text = stream.str(), fence = "```yaml\n";
  const std::size_t from = text.find(fence, text.find("## Shorthand")) + fence.size();
  const std::string frame = text.substr(from, text.find("```", from) - from);
  EXPECT_LE(std::count(frame.begin(), frame.end(), '\n'), 25);
  return parse_scene(frame, "docs/scene.md");
}

TEST(Shorthand, TheFrameInTwentyFiveLinesIsTheFrame) {
  const Scene written = frame_scene(), shorter = documented_frame();
  const LinearModel a = linearise(make_model(written), written.inputs, written.outputs),
                    b = linearise(make_model(shorter), shorter.inputs, shorter.outputs);
  const auto near = [](const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
    ASSERT_EQ(x.rows(), y.rows());
    ASSERT_EQ(x.cols(), y.cols());
    // The file has fifteen digits of its positions.
    EXPECT_LT((x - y).cwiseAbs().maxCoeff(), 1e-12 * (1 + x.cwiseAbs().maxCoeff()));
  };
  near(a.M, b.M);
  near(a.K, b.K);
  near(a.M_r, b.M_r);
  near(a.Y_p, b.Y_p);
  near(a.Y_a, b.Y_a);
  near(a.R_a, b.R_a);
  near(a.D_u, b.D_u);
  EXPECT_EQ(shorter.controller->legs, written.controller->legs);
}

/// What is repeated about an axis is the first one, turned: as tests turn whole scenes.
TEST(Shorthand, RepetitionsAboutAnAxisAreTheFirstTurned) {
  for (const char axis : {'x', 'y', 'z'}) {
    for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 12, 360}) {
      const std::string text =
          std::string("title: t\nnodes:\n  a_#: {repeat: ") + std::to_string(n) +
          ", about: " + axis +
          ", position: [0.3, -0.2, 0.7]}\nmasses:\n  - {repeat: " + std::to_string(n) +
          ", about: " + axis +
          ", node: a_#, mass: 1, inertia: [1, 2, 2.5]}\nelements: {}\n"
          "dofs: auto\nloads:\n  - {repeat: " +
          std::to_string(n) + ", about: " + axis +
          ", node: a_#, force: [1, 2, 3], torque: [3, -2, 1]}\ninputs:\n"
          "  - {repeat: " +
          std::to_string(n) + ", about: " + axis +
          ", name: in_#, force: a_#, along: x}\noutputs:\n  - {repeat: " + std::to_string(n) +
          ", about: " + axis + ", name: out_#, position: a_#, along: [0, 2, 1]}\n";
      const Scene scene = parse_scene(text, "t.yaml");
      ASSERT_EQ(scene.nodes.size(), static_cast<std::size_t>(n));
      for (int i = 0; i < n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Eigen::Matrix3d R =
            Eigen::AngleAxisd(2 * std::numbers::pi * i / n, Eigen::Vector3d::Unit(axis - 'x'))
                .toRotationMatrix();
        const auto near = [&](const auto& x, const auto& y) {
          // Rounding of numbers below 4.
          EXPECT_LT((x - y).cwiseAbs().maxCoeff(), 4e-15) << axis << " " << n << " " << i;
        };
        const Eigen::Vector3d position(0.3, -0.2, 0.7), along = Eigen::Vector3d(0, 2, 1);
        near(scene.nodes[at].position, R * position);
        near(scene.masses[at].inertia, R * Eigen::Vector3d(1, 2, 2.5).asDiagonal() * R.transpose());
        near(scene.loads[at].force, R * Eigen::Vector3d(1, 2, 3));
        near(scene.loads[at].torque, R * Eigen::Vector3d(3, -2, 1));
        near(scene.inputs[at].direction, R * Eigen::Vector3d::UnitX());
        near(scene.outputs[at].direction.normalized(), R * along.normalized());
        EXPECT_EQ(scene.nodes[at].name, "a_" + std::to_string(i + 1));
      }
    }
  }
}

TEST(Shorthand, ThirdsOfATurnLeaveNoRemainder) {
  for (int parts : {1, 2, 3, 4, 6, 12}) {
    Turn sum{.cos = 0, .sin = 0};
    for (int i = 0; i < parts; ++i) {
      const Turn turn = turn_of_part(i, parts);
      sum.cos += turn.cos;
      sum.sin += turn.sin;
      EXPECT_NEAR(turn.cos, std::cos(2 * std::numbers::pi * i / parts), 1e-15);
      EXPECT_NEAR(turn.sin, std::sin(2 * std::numbers::pi * i / parts), 1e-15);
    }
    // Twelve have sums of three numbers that round on the way.
    if (parts == 12) continue;
    EXPECT_EQ(sum.cos, parts == 1 ? 1 : 0);
    EXPECT_EQ(sum.sin, 0);
  }
  EXPECT_EQ(turn_of_degrees(-90).sin, -1);
  EXPECT_EQ(turn_of_degrees(180).sin, 0);
  EXPECT_NEAR(turn_of_degrees(20).sin, std::sin(std::numbers::pi / 9), 1e-16);
}

YamlReader read(const std::string& text) { return YamlReader::from_text(text, "a.yaml"); }

TEST(Shorthand, WritesOutWhatItSays) {
  const YamlReader all = read(
      "variables: {n: 2, gap: =n/4}\n"
      "# a note\n"
      "grid: [{repeat: =n, of: [{repeat: 3, of: [p_##_#, [=##, =gap*#]]}]}]\n"
      "map: {a_#: {repeat: 2, b_#_##: {repeat: =#, c: '## #'}}}\n"
      "polar: {radius: 2, angle_deg: =360*n/4, z: =-gap}\n"
      "word: mount_#\n"
      "nothing: ~\n");
  EXPECT_EQ(all.require("grid").dump(),
            read("grid: [p_1_1, [1, 0.5], p_1_2, [1, 1], p_1_3, [1, 1.5], p_2_1, [2, 0.5], p_2_2, "
                 "[2, 1], p_2_3, [2, 1.5]]\nx: =0")
                .require("grid")
                .dump());
  EXPECT_EQ(all.require("map").dump(),
            read("map: {a_1: {b_1_1: {c: 1 1}}, a_2: {b_1_2: {c: 2 1}, b_2_2: {c: 2 2}}}\nx: =0")
                .require("map")
                .dump());
  EXPECT_EQ(all.require("polar").vector(3), Eigen::Vector3d(-2, 0, -0.5));
  EXPECT_EQ(all.require("word").text(), "mount_#") << "outside a repetition it is a letter";
  EXPECT_FALSE(all.find("variables"));
  EXPECT_EQ(all.as_written().require("variables").require("gap").text(), "=n/4");
}

/// Everything that is read anew is what it was: a file without shorthand and the same beside a
/// formula, which has all of it written out.
TEST(Shorthand, TheRestOfAFileStaysAsItIs) {
  for (const char* const name : {"metrology_frame", "cart", "meshed_frame"}) {
    std::ifstream file(std::string(STILLFRAME_SOURCE_DIR "/config/scenes/") + name + ".yaml");
    std::stringstream text;
    text << file.rdbuf();
    const YamlReader plain = read(text.str()),
                     written = read(text.str() + "\nzz: {radius: =1, angle_deg: 0, z: 1}\n");
    for (const auto& [key, value] : plain.entries()) {
      const YamlReader other = written.require(key);
      EXPECT_EQ(other.place(), value.place()) << "messages name the same line";
      const auto same = [&](const auto& self, const YamlReader& a, const YamlReader& b) -> void {
        EXPECT_EQ(a.place(), b.place()) << a.name();
        ASSERT_EQ(a.is_map(), b.is_map());
        ASSERT_EQ(a.is_sequence(), b.is_sequence());
        if (a.is_scalar()) {
          EXPECT_EQ(a.text(), b.text());
        }
        if (a.is_sequence()) {
          const auto x = a.items(), y = b.items();
          ASSERT_EQ(x.size(), y.size());
          for (std::size_t i = 0; i < x.size(); ++i) self(self, x[i], y[i]);
        }
        if (a.is_map()) {
          const auto x = a.entries(), y = b.entries();
          ASSERT_EQ(x.size(), y.size());
          for (std::size_t i = 0; i < x.size(); ++i) {
            ASSERT_EQ(x[i].first, y[i].first);
            self(self, x[i].second, y[i].second);
          }
        }
      };
      same(same, value, other);
    }
  }
}

TEST(Shorthand, WhatIsWrongIsOneMessageWithItsPlace) {
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto says = [&](const std::string& text, const std::string& message) {
    EXPECT_EQ(error_of(text).substr(0, message.size()), message) << text << "\n" << error_of(text);
  };
  says("a: =", "a.yaml:1:4: '=': found its end, allowed is a number, a name or '('");
  says("a: =1 +", "a.yaml:1:4: '=1 +': found its end");
  says("a: =(1", "a.yaml:1:4: '=(1': found its end, allowed is ')'");
  says("a: =2#", "a.yaml:1:4: '=2#': found '#', allowed is an operator");
  says("a: =1/0", "a.yaml:1:4: '=1/0' is no finite number");
  says("a: =sqrt 2", "a.yaml:1:4: '=sqrt 2': found '2', allowed is '(' behind sqrt");
  says("a: =#", "a.yaml:1:4: '=#': # counts in a repetition (repeat: N), and here is none");
  says("a: [{repeat: 2, b: =##}]",
       "a.yaml:1:20: '=##': ## counts in repetitions inside each other");
  says("a: [{repeat: 2, b: c_##}]", "a.yaml:1:20: found 'c_##' in 1 repetitions");
  says("variables: {r: 1}\na: =R", "a.yaml:2:4: '=R': no variable above is called 'R'; functions");
  says("variables: {a: =b, b: 1}\nc: =a", "a.yaml:1:16: '=b': no variable above is called 'b'");
  says("variables: {r: 1}\na: 2", "a.yaml:1:13: variables.r: nothing uses it");
  says("variables: {pi: 3}\na: =pi", "a.yaml:1:13: variables.pi: allowed is a word");
  says("variables: {r: one}\na: =r", "a.yaml:1:16: variables.r: found 'one', allowed is a number");
  says("variables: [1]\na: =r", "a.yaml:1:12: variables: allowed is a map");
  for (const char* const n : {"0", "-1", "2.5", "10001", "1e9", "x", "~", "[2]"}) {
    says(std::string("a: [{repeat: ") + n + ", b: c_#}]", "a.yaml:1:14: repeat: found '");
  }
  says("a: [{repeat: 2, about: w, b: 1}]", "a.yaml:1:24: about: found 'w', allowed is x, y or z");
  says("planar: true\na: [{repeat: 2, about: x, b: 1}]",
       "a.yaml:2:24: about: found 'x', allowed is z");
  says("a: {b: {repeat: 2, c: 1}}", "a.yaml:1:5: b: this key comes twice; in a repetition");
  says("a: [{repeat: 2, of: [1], b: 1}]", "a.yaml:1:21: of: allowed is a sequence");
  says("a: {radius: 1, angle_deg: 3}", "a.yaml:1:4: a polar position needs z");
  says("a: {z: 1, angle_deg: 3}", "a.yaml:1:4: a polar position needs a radius");
  says("a: {radius: 1, angle_deg: 3, height: 2}", "a.yaml:1:30: height: unknown key of a polar");
  says("a: {radius: x, angle_deg: 3, z: 2}", "a.yaml:1:13: radius: allowed is a number");
  // What the reader says of what was written out has the place of the writing.
  try {
    read("a:\n  - {repeat: 3, b: =#-2, c: [x]}\n").require("a").items()[2].allow_only({"b"});
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "a.yaml:2:26: a[3].c: unknown key; allowed: b");
  }
  // Short texts that stand for more than there is memory.
  std::string bomb = "x";
  for (int i = 0; i < 12; ++i) bomb = "{repeat: 10000, of: [" + bomb + "]}";
  says("a: [" + bomb + "]", "a.yaml:1:");
  EXPECT_NE(error_of("a: [" + bomb + "]").find("values with all repetitions"), std::string::npos);
  says("a: =" + std::string(300, '('), "a.yaml:1:4: '=((((");
  says("a: =" + std::string(100000, '('), "a.yaml:1:4: found a formula of 100000 characters");
  says("a: =" + std::string(100000, '-') + "1", "a.yaml:1:4: found a formula of");
}

}  // namespace
}  // namespace stillframe::test
