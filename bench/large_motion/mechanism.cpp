#include "bench/large_motion/mechanism.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace stillframe::race {

using Eigen::Index;
using Eigen::Vector3d;
using Json = nlohmann::json;

namespace {

Json of(const Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }
Vector3d vector(const Json& v) {
  return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}

Json of(const Point& point) { return {{"body", point.body}, {"position", of(point.position)}}; }
Point point(const Json& value) { return {value.at("body"), vector(value.at("position"))}; }

Json of(const Eigen::Matrix3d& J) {
  return Json::array({of(Vector3d(J.row(0))), of(Vector3d(J.row(1))), of(Vector3d(J.row(2)))});
}

}  // namespace

std::string to_text(const Mechanism& mechanism) {
  Json bodies = Json::array(), springs = bodies, guides = bodies, outputs = bodies, base = bodies;
  for (const RigidBody& body : mechanism.bodies) {
    bodies.push_back({{"joint", body.joint},
                      {"parent", body.parent},
                      {"hinge", of(body.hinge)},
                      {"axis", of(body.axis)},
                      {"stiffness", body.stiffness},
                      {"damping", body.damping},
                      {"mass", body.mass},
                      {"centre", of(body.centre)},
                      {"inertia", of(body.J)}});
  }
  for (const Spring& spring : mechanism.springs) {
    springs.push_back({{"from", of(spring.from)},
                       {"to", of(spring.to)},
                       {"stiffness", spring.stiffness},
                       {"damping", spring.damping},
                       {"input", spring.input},
                       {"direction", of(spring.direction)}});
  }
  for (const PlaneGuide& guide : mechanism.guides) {
    guides.push_back({{"point", of(guide.point)}, {"normal", of(guide.normal)}});
  }
  for (const Output& output : mechanism.outputs) {
    outputs.push_back({{"point", of(output.point)}, {"direction", of(output.direction)}});
  }
  for (const Vector3d& direction : mechanism.base_inputs) base.push_back(of(direction));
  const Json all{{"gravity", of(mechanism.gravity)},
                 {"sample_time", mechanism.sample_time},
                 {"bodies", bodies},
                 {"springs", springs},
                 {"guides", guides},
                 {"outputs", outputs},
                 {"base_inputs", base}};
  return all.dump(1);
}

Mechanism from_text(const std::string& text) {
  const Json all = Json::parse(text);
  Mechanism mechanism;
  mechanism.gravity = vector(all.at("gravity"));
  mechanism.sample_time = all.at("sample_time");
  for (const Json& item : all.at("bodies")) {
    RigidBody body;
    body.joint = item.at("joint");
    body.parent = item.at("parent");
    body.hinge = vector(item.at("hinge"));
    body.axis = vector(item.at("axis"));
    body.stiffness = item.at("stiffness");
    body.damping = item.at("damping");
    body.mass = item.at("mass");
    body.centre = vector(item.at("centre"));
    for (Index i = 0; i < 3; ++i) {
      body.J.row(i) = vector(item.at("inertia").at(static_cast<size_t>(i)));
    }
    mechanism.bodies.push_back(body);
  }
  for (const Json& item : all.at("springs")) {
    mechanism.springs.push_back({point(item.at("from")), point(item.at("to")), item.at("stiffness"),
                                 item.at("damping"), item.at("input"),
                                 vector(item.at("direction"))});
  }
  for (const Json& item : all.at("guides")) {
    mechanism.guides.push_back({point(item.at("point")), vector(item.at("normal"))});
  }
  for (const Json& item : all.at("outputs")) {
    mechanism.outputs.push_back({point(item.at("point")), vector(item.at("direction"))});
  }
  for (const Json& item : all.at("base_inputs")) mechanism.base_inputs.push_back(vector(item));
  return mechanism;
}

Eigen::MatrixXd sines(Index inputs, Index samples, double sample_time, double amplitude,
                      double lowest_hz, double highest_hz) {
  constexpr Index lines = 7;
  const double pi = std::acos(-1.0);
  Eigen::MatrixXd a(inputs, samples);
  for (Index i = 0; i < inputs; ++i) {
    for (Index k = 0; k < samples; ++k) {
      const double t = static_cast<double>(k) * sample_time;
      double sum = 0;
      for (Index line = 0; line < lines; ++line) {
        // Frequencies that no two inputs share, and phases without a pattern.
        const double step = (static_cast<double>(line) +
                             static_cast<double>(i + 1) / static_cast<double>(inputs + 1)) /
                            lines;
        const double hz = lowest_hz * std::pow(highest_hz / lowest_hz, step);
        const auto phase = static_cast<double>((7 * i + 3 * line * line) % 11);
        sum += std::sin(2 * pi * hz * t + phase);
      }
      a(i, k) = amplitude / std::sqrt(static_cast<double>(lines)) * sum;
    }
  }
  return a;
}

}  // namespace stillframe::race
