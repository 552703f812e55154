#include "core/mechanics/scene/scene_builder.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "core/mechanics/scene/quantity.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/yaml/quoted.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

namespace {

const char* const builder_name = "scene builder";

/// Plain where a person would write it plain.
std::string written_name(const std::string& name) {
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const auto plain = [&](char c) {
    return letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '/';
  };
  const bool nothing = name == "null" || name == "Null" || name == "NULL";
  const bool is_word =
      !name.empty() && letter(name.front()) && std::all_of(name.begin(), name.end(), plain);
  return is_word && !nothing ? name : quoted(name);
}

template <class Items, class Written>
std::string sequence(const Items& items, Written written) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ", ") + written(item);
  return "[" + text + "]";
}

std::string written_names(const std::vector<std::string>& all) {
  return sequence(all, written_name);
}

std::string written_directions(const std::vector<SceneDirection>& all) {
  return sequence(all, [](const SceneDirection& direction) { return direction.text(); });
}

/// {key: value, ...} on one line, of what is given.
class Entry {
 public:
  Entry& add(const char* key, const std::string& value) {
    if (!value.empty()) text_ += (text_.empty() ? "" : ", ") + std::string(key) + ": " + value;
    return *this;
  }
  Entry& add(const char* key, const SceneNumbers& value) { return add(key, value.text()); }
  Entry& add(const char* key, const SceneDirection& value) { return add(key, value.text()); }
  Entry& add(const char* key, std::optional<double> value) {
    return add(key, value ? shortest_digits(*value) : "");
  }
  Entry& add(const char* key, std::optional<int> value) {
    return add(key, value ? std::to_string(*value) : "");
  }
  Entry& flag(const char* key, bool set) { return add(key, std::string(set ? "true" : "")); }

  /// As an entry of a block that is a map, or that is a sequence.
  std::string entry(const std::string& name) const {
    return "  " + written_name(name) + ": " + braced() + "\n";
  }
  std::string item() const { return "  - " + braced() + "\n"; }
  std::string braced() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

Entry nodes_of(const char* type, const std::string& p, const std::string& q) {
  return Entry().add("type", std::string(type)).add("nodes", written_names({p, q}));
}

Entry start_of(Entry dof, const StartKeys& start) {
  return dof.add("value", start.value).add("rate", start.rate);
}

Entry motion_of(Entry prescribed, const MotionKeys& motion) {
  return prescribed.add("value", motion.value)
      .add("rate", motion.rate)
      .add("acceleration", motion.acceleration);
}

std::string signal_of(const std::string& name, Quantity quantity, const std::string& of,
                      const SceneComponent& component) {
  return Entry()
      .add("name", written_name(name))
      .add(traits_of(quantity).word, written_name(of))
      .add("along", component.along())
      .add("mode", component.mode())
      .item();
}

std::string feed_forward_of(const FeedForwardKeys& keys) {
  return Entry()
      .add("to_hz", keys.to_hz)
      .add("corner_hz", keys.corner_hz)
      .add("target_hz", keys.target_hz)
      .add("damping_ratio", keys.damping_ratio)
      .add("at_most_db", keys.at_most_db)
      .add("actuator_error", keys.actuator_error)
      .add("noise_over_floor", keys.noise_over_floor)
      .add("taps", keys.taps)
      .braced();
}

/// One of two words, of what is given.
template <class Choice>
std::string word_if(std::optional<Choice> choice, Choice first, const char* first_word,
                    const char* other_word) {
  if (!choice) return "";
  return *choice == first ? first_word : other_word;
}

/// A block of the scene; `without` stands for one that has nothing.
std::string with_key(const char* key, const std::string& lines, const char* without = "") {
  if (lines.empty()) return without;
  return std::string(key) + ":\n" + lines;
}

/// What an error says, with the line of the text that it is about, as nobody has seen the text.
std::string with_line(const std::string& message, const std::string& text) {
  const std::string start = std::string(builder_name) + ":";
  if (!message.starts_with(start)) return message;  // of a file that a block names
  int number = 0;
  std::from_chars(message.data() + start.size(), message.data() + message.size(), number);
  std::istringstream in(text);
  std::string line;
  for (int i = 0; i < number; ++i) std::getline(in, line);
  return message + ", in: " + line.substr(std::min(line.find_first_not_of(' '), line.size()));
}

}  // namespace

SceneNumbers::SceneNumbers(double number) : text_(shortest_digits(number)) {}

SceneNumbers::SceneNumbers(std::initializer_list<double> numbers)
    : text_(sequence(numbers, shortest_digits)) {}

std::string SceneNumbers::written(const Eigen::MatrixXd& numbers) {
  const auto row = [](const auto& values) {
    return sequence(std::vector<double>(values.begin(), values.end()), shortest_digits);
  };
  return numbers.cols() == 1 ? row(numbers.col(0)) : sequence(numbers.rowwise(), row);
}

SceneDirection::SceneDirection(const char* word) : text_(written_name(word)) {}

SceneDirection::SceneDirection(std::initializer_list<double> components)
    : text_(SceneNumbers(components).text()) {}

SceneBuilder::SceneBuilder(const std::string& title) : head_("title: " + quoted(title) + "\n") {}

SceneBuilder& SceneBuilder::planar() {
  head_ += "planar: true\n";
  return *this;
}

SceneBuilder& SceneBuilder::gravity(const SceneNumbers& acceleration) {
  head_ += "gravity: " + acceleration.text() + "\n";
  return *this;
}

SceneBuilder& SceneBuilder::modal_damping(const SceneNumbers& ratios) {
  head_ += "modal_damping: " + ratios.text() + "\n";
  return *this;
}

SceneBuilder& SceneBuilder::as_written() {
  head_ += "operating_point: as_written\n";
  return *this;
}

SceneBuilder& SceneBuilder::node(const std::string& name, const SceneNumbers& position) {
  nodes_ += Entry().add("position", position).entry(name);
  return *this;
}

SceneBuilder& SceneBuilder::mass(const std::string& node, double mass,
                                 const SceneNumbers& inertia) {
  masses_ += Entry()
                 .add("node", written_name(node))
                 .add("mass", SceneNumbers(mass))
                 .add("inertia", inertia)
                 .item();
  return *this;
}

SceneBuilder& SceneBuilder::truss(const std::string& name, const std::string& p,
                                  const std::string& q, const TrussKeys& keys) {
  elements_ += nodes_of("truss", p, q)
                   .add("stiffness", keys.stiffness)
                   .add("damping", keys.damping)
                   .add("preload", keys.preload)
                   .flag("rigid", keys.rigid)
                   .entry(name);
  return *this;
}

SceneBuilder& SceneBuilder::beam(const std::string& name, const std::string& p,
                                 const std::string& q, const BeamKeys& keys) {
  elements_ += nodes_of("beam", p, q)
                   .add("orientation", keys.orientation)
                   .add("EA", keys.EA)
                   .add("GJ", keys.GJ)
                   .add("EI_y", keys.EI_y)
                   .add("EI_z", keys.EI_z)
                   .add("EI", keys.EI)
                   .add("shear_y", keys.shear_y)
                   .add("shear_z", keys.shear_z)
                   .add("shear", keys.shear)
                   .add("mass_per_length", keys.mass_per_length)
                   .add("inertia_per_length", keys.inertia_per_length)
                   .add("mass", std::string(keys.lumped_mass ? "lumped" : ""))
                   .flag("second_order", keys.second_order)
                   .add("stiffness", keys.stiffness)
                   .add("damping", keys.damping)
                   .add("damping_time", keys.damping_time)
                   .add("rigid", keys.rigid)
                   .add("preload", keys.preload)
                   .add("divide", keys.divide)
                   .entry(name);
  return *this;
}

SceneBuilder& SceneBuilder::rigid_beam(const std::string& name, const std::string& p,
                                       const std::string& q) {
  elements_ += nodes_of("rigid_beam", p, q).entry(name);
  return *this;
}

SceneBuilder& SceneBuilder::hinge(const std::string& name, const std::string& p,
                                  const std::string& q, const HingeKeys& keys) {
  elements_ += nodes_of("hinge", p, q)
                   .add("axis", keys.axis)
                   .add("rigid", keys.rigid)
                   .add("rigid", std::string(keys.ball ? "[]" : ""))
                   .add("stiffness", keys.stiffness)
                   .add("damping", keys.damping)
                   .add("preload", keys.preload)
                   .entry(name);
  return *this;
}

SceneBuilder& SceneBuilder::superelement(const std::string& name,
                                         const std::vector<std::string>& nodes,
                                         const std::string& body,
                                         std::optional<double> damping_time) {
  elements_ += Entry()
                   .add("type", std::string("superelement"))
                   .add("nodes", written_names(nodes))
                   .add("body", quoted(body))
                   .add("damping_time", damping_time)
                   .entry(name);
  return *this;
}

SceneBuilder& SceneBuilder::support(const std::string& node,
                                    const std::vector<SceneDirection>& fix) {
  supports_ +=
      Entry().add("nodes", written_names({node})).add("fix", written_directions(fix)).item();
  return *this;
}

SceneBuilder& SceneBuilder::prescribe(const std::string& node,
                                      const std::vector<SceneDirection>& move,
                                      const MotionKeys& motion) {
  prescribed_ +=
      motion_of(Entry().add("nodes", written_names({node})).add("move", written_directions(move)),
                motion)
          .item();
  return *this;
}

SceneBuilder& SceneBuilder::prescribe_element(const std::string& element, std::optional<int> mode,
                                              const MotionKeys& motion) {
  prescribed_ +=
      motion_of(Entry().add("element", written_name(element)).add("mode", mode), motion).item();
  return *this;
}

SceneBuilder& SceneBuilder::dof_of_element(const std::string& element, std::optional<int> mode,
                                           const StartKeys& start) {
  dofs_ += start_of(Entry().add("element", written_name(element)).add("mode", mode), start).item();
  return *this;
}

SceneBuilder& SceneBuilder::dofs_of(const std::string& element) {
  dofs_ += Entry().add("deformations", written_name(element)).item();
  return *this;
}

SceneBuilder& SceneBuilder::dof_of_node(const std::string& node, const SceneDirection& along,
                                        const StartKeys& start) {
  dofs_ += start_of(Entry().add("node", written_name(node)).add("along", along), start).item();
  return *this;
}

SceneBuilder& SceneBuilder::dof_of_rotation(const std::string& node, const StartKeys& start) {
  dofs_ += start_of(Entry().add("node", written_name(node)).flag("rotation", true), start).item();
  return *this;
}

SceneBuilder& SceneBuilder::dof_of_euler_parameter(const std::string& node, int parameter,
                                                   const StartKeys& start) {
  dofs_ += start_of(Entry()
                        .add("node", written_name(node))
                        .add("euler_parameter", std::optional<int>(parameter)),
                    start)
               .item();
  return *this;
}

SceneBuilder& SceneBuilder::automatic_dofs() {
  // Of its own, so that beside chosen ones the key stands twice, which is refused.
  head_ += "dofs: auto\n";
  return *this;
}

SceneBuilder& SceneBuilder::load(const std::string& node, const LoadKeys& keys) {
  loads_ += Entry()
                .add("node", written_name(node))
                .add("force", keys.force)
                .add("torque", keys.torque)
                .flag("follows", keys.follows)
                .item();
  return *this;
}

SceneBuilder& SceneBuilder::input(const std::string& name, Quantity quantity, const std::string& of,
                                  const SceneComponent& component) {
  inputs_ += signal_of(name, quantity, of, component);
  return *this;
}

SceneBuilder& SceneBuilder::output(const std::string& name, Quantity quantity,
                                   const std::string& of, const SceneComponent& component) {
  outputs_ += signal_of(name, quantity, of, component);
  return *this;
}

SceneBuilder& SceneBuilder::monitor(const std::string& name, Quantity quantity,
                                    const std::string& of, const SceneComponent& component) {
  monitors_ += signal_of(name, quantity, of, component);
  return *this;
}

SceneBuilder& SceneBuilder::controller(const ControllerKeys& keys) {
  blocks_ +=
      "controller: " +
      Entry()
          .add("legs", written_names(keys.legs))
          .add("target_hz", keys.target_hz)
          .add("damping_ratio", keys.damping_ratio)
          .add("order", word_if(keys.order, GainOrder::exact, "exact", "deck"))
          .add("reduction", word_if(keys.reduction, Reduction::modes, "modes", "static_shapes"))
          .add("realisation",
               word_if(keys.realisation, Realisation::naive_pi, "naive_pi", "implicit_feedthrough"))
          .add("sample_rate_hz", keys.sample_rate_hz)
          .add("delay_samples", keys.delay_samples)
          .add("leak_hz", keys.leak_hz)
          .add("high_pass_hz", keys.high_pass_hz)
          .add("lead_samples", keys.lead_samples)
          .add("roll_off_hz", keys.roll_off_hz)
          .add("force_limit_n", keys.force_limit_n)
          .add("feed_forward", keys.feed_forward ? feed_forward_of(*keys.feed_forward) : "")
          .add("law", keys.law.empty() ? "" : quoted(keys.law))
          .braced() +
      "\n";
  return *this;
}

SceneBuilder& SceneBuilder::block(const std::string& key, const std::string& yaml) {
  blocks_ += written_name(key) + ":\n";
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) blocks_ += "  " + line + "\n";
  return *this;
}

std::string SceneBuilder::text() const {
  return head_ + with_key("nodes", nodes_) + with_key("masses", masses_, "masses: []\n") +
         with_key("elements", elements_, "elements: {}\n") + with_key("supports", supports_) +
         with_key("prescribed", prescribed_) + with_key("dofs", dofs_) + with_key("loads", loads_) +
         with_key("inputs", inputs_) + with_key("outputs", outputs_) +
         with_key("monitors", monitors_) + blocks_;
}

Scene SceneBuilder::build() const {
  const std::string scene = text();
  try {
    return parse_scene(scene, builder_name);
  } catch (const InputError& error) {
    // Says the same again of a text that is no YAML, as of a name with bytes that no message shows.
    YamlReader::from_text(scene, builder_name);
    throw InputError(with_line(error.what(), scene));
  }
}

}  // namespace stillframe
