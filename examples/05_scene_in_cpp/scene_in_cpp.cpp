// A scene without a file: a row of ten masses on springs. What is printed first is its text, which
// every program takes: scene_in_cpp > chain.yaml, stillframe modes chain.yaml
#include <iostream>
#include <stillframe.hpp>

using namespace stillframe;

int main() try {
  SceneBuilder chain("A chain of ten masses");
  chain.node("wall", {0, 0, 0}).prescribe("wall", {"x", "y", "z"});
  std::string last = "wall";
  for (int i = 1; i <= 10; ++i) {
    const std::string mass = "mass_" + std::to_string(i), spring = "spring_" + std::to_string(i);
    chain.node(mass, {0.1 * i, 0, 0})
        .mass(mass, 10)
        .support(mass, {"y", "z"})
        .truss(spring, last, mass, {.stiffness = 4e5, .damping = 20})
        .dof_of_element(spring);
    last = mass;
  }
  chain.input("wall", Quantity::acceleration, "wall", "x")
      .output("end", Quantity::acceleration, last, "x");
  const Scene scene = chain.build();

  const auto linear = linearise(make_model(scene), scene.inputs, scene.outputs);
  std::cout << scene.text
            << "# Natural frequencies (Hz): " << modes(linear).natural_frequencies_hz.transpose()
            << "\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
