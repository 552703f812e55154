#include "tools/spacar/scene_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/yaml/quoted.hpp"
#include "core/yaml/reader.hpp"
#include "tools/spacar/element_keys.hpp"
#include "tools/spacar/source_text.hpp"

namespace stillframe::tools::spacar {

namespace {

/// Where comments begin, and where a line of keys is broken.
constexpr std::size_t comment_column = 60, line_width = 100;

std::string with_comment(const std::string& line, const std::string& comment) {
  std::string text = line;
  text.resize(std::max(comment_column, line.size() + 2), ' ');
  text += "# ";
  text += comment;
  return text += '\n';
}

/// `start {key: value, ...}`, broken where it gets too long; the comment is on its first line.
std::string entry(const std::string& start, const Keys& keys, const std::string& comment) {
  std::vector<std::string> lines{start + '{'};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string piece =
        keys[i].first + ": " + keys[i].second + (i + 1 < keys.size() ? "," : "}");
    const bool first = lines.back().ends_with('{');
    if (!first && lines.back().size() + 1 + piece.size() > line_width) {
      lines.push_back("    " + piece);
    } else {
      lines.back() += (first ? "" : " ") + piece;
    }
  }
  std::string text = with_comment(lines.front(), comment);
  for (std::size_t i = 1; i < lines.size(); ++i) text += lines[i] + '\n';
  return text;
}

std::string head(const Model& model) {
  std::string text = "# From " + shown(model.title) +
                     " of SPACAR, by `stillframe import`. All in SI units; the comments\n"
                     "# say from which of its lines each entry came.\n";
  const auto list = [&](const std::string& title, const std::vector<Remark>& remarks) {
    if (remarks.empty()) return;
    text += "#\n# " + title + "\n";
    for (const Remark& remark : remarks) {
      text += "#   line " + std::to_string(remark.line) + ": " + shown(remark.what) + ": " +
              remark.why + "\n";
    }
  };
  for (const std::string& given : model.given) text += "# Given: --set " + shown(given) + "\n";
  list("Not in this scene:", model.remarks.left_out);
  list("In another form:", model.remarks.approximated);
  return text + "title: " + quoted(model.title) + "\n";
}

std::string vector_of(const Eigen::Vector3d& v, bool planar) {
  std::vector<double> numbers{v.x(), v.y()};
  if (!planar) numbers.push_back(v.z());
  return list_of(numbers);
}

bool turns_freely(const Model& model, const std::string& node) {
  return std::none_of(model.supports.begin(), model.supports.end(), [&](const Support& support) {
    return support.node == node &&
           std::find(support.fix.begin(), support.fix.end(), "rotation") != support.fix.end();
  });
}

/// One entry a node: XM, what trusses weigh, and the rotary inertia that a beam of a scene has not.
std::string masses(const Model& model, const std::vector<Mass>& of_elements) {
  std::vector<std::string> order;
  std::map<std::string, Mass> sums;
  const auto add = [&](const Mass& mass) {
    if (!sums.contains(mass.node)) order.push_back(mass.node);
    Mass& sum = sums[mass.node];
    sum.mass += mass.mass;
    sum.inertia += mass.inertia;
    sum.lines.insert(mass.lines.begin(), mass.lines.end());
  };
  for (const Mass& mass : model.masses) add(mass);
  for (const Mass& mass : of_elements) {
    if (mass.mass > 0 || turns_freely(model, mass.node)) add(mass);
  }
  if (order.empty()) return "masses: []\n";
  std::string text = "masses:\n";
  for (const std::string& node : order) {
    const Mass& mass = sums.at(node);
    Keys keys{{"node", node}, {"mass", shortest_digits(mass.mass)}};
    if (model.planar) {
      if (mass.inertia(2, 2) != 0)
        keys.emplace_back("inertia", shortest_digits(mass.inertia(2, 2)));
    } else if (!mass.inertia.isZero(0)) {
      keys.emplace_back("inertia", matrix_of(mass.inertia));
    }
    text += entry("  - ", keys, lines_of(mass.lines));
  }
  return text;
}

std::string supports(const Model& model) {
  std::string text;
  std::map<std::string, Support> sums;
  std::vector<std::string> order;
  for (const Support& support : model.supports) {
    if (!sums.contains(support.node)) order.push_back(support.node);
    Support& sum = sums[support.node];
    for (const std::string& direction : support.fix) {
      if (std::find(sum.fix.begin(), sum.fix.end(), direction) == sum.fix.end()) {
        sum.fix.push_back(direction);
      }
    }
    sum.lines.insert(support.lines.begin(), support.lines.end());
  }
  for (const std::string& node : order) {
    const Support& support = sums.at(node);
    std::string list;
    for (const char* direction : {"x", "y", "z", "rotation"}) {
      if (std::find(support.fix.begin(), support.fix.end(), direction) == support.fix.end())
        continue;
      if (!list.empty()) list += ", ";
      list += direction;
    }
    text += entry("  - ", {{"nodes", '[' + node + ']'}, {"fix", '[' + list + ']'}},
                  lines_of(support.lines));
  }
  return text.empty() ? text : "supports:\n" + text;
}

std::string prescribed(const Model& model) {
  std::string text;
  for (const Motion& motion : model.motions) {
    Keys keys;
    if (motion.element.empty()) {
      keys = {{"nodes", '[' + motion.node + ']'}, {"move", '[' + motion.along + ']'}};
    } else {
      keys = {{"element", motion.element}, {"mode", std::to_string(motion.mode)}};
    }
    if (motion.value != 0) keys.emplace_back("value", shortest_digits(motion.value));
    if (motion.rate != 0) keys.emplace_back("rate", shortest_digits(motion.rate));
    if (motion.acceleration != 0) {
      keys.emplace_back("acceleration", shortest_digits(motion.acceleration));
    }
    text += entry("  - ", keys, lines_of(motion.lines));
  }
  return text.empty() ? text : "prescribed:\n" + text;
}

std::string loads(const Model& model) {
  std::string text;
  std::map<std::string, Load> sums;
  std::vector<std::string> order;
  for (const Load& load : model.loads) {
    if (!sums.contains(load.node)) order.push_back(load.node);
    Load& sum = sums[load.node];
    sum.force += load.force;
    sum.torque += load.torque;
    sum.lines.insert(load.lines.begin(), load.lines.end());
  }
  for (const std::string& node : order) {
    const Load& load = sums.at(node);
    Keys keys{{"node", node}};
    if (!load.force.isZero(0)) keys.emplace_back("force", vector_of(load.force, model.planar));
    if (!load.torque.isZero(0)) {
      keys.emplace_back("torque", model.planar ? shortest_digits(load.torque.z())
                                               : vector_of(load.torque, false));
    }
    if (keys.size() > 1) text += entry("  - ", keys, lines_of(load.lines));
  }
  return text.empty() ? text : "loads:\n" + text;
}

std::string signals(const std::string& block, const std::vector<Signal>& all) {
  std::string text;
  for (const Signal& signal : all) {
    Keys keys{{"name", lower(signal.name)}, {signal.quantity, signal.of}};
    if (!signal.along.empty()) keys.emplace_back("along", signal.along);
    if (signal.mode > 0) keys.emplace_back("mode", std::to_string(signal.mode));
    text += entry("  - ", keys, lines_of(signal.lines));
  }
  return text.empty() ? text : block + ":\n" + text;
}

}  // namespace

std::string scene_text(Model& model) {
  std::string nodes = "nodes:\n", elements;
  for (const Node& node : model.nodes) {
    nodes += entry("  " + node.name + ": ", {{"position", vector_of(node.position, model.planar)}},
                   lines_of(node.lines));
  }
  std::vector<Mass> of_elements;
  for (const Element& element : model.elements) {
    elements += entry("  " + element.name + ": ", element_keys(model, element, of_elements),
                      lines_of(element.lines));
  }
  sort_by_line(model.remarks);
  // Elements first: masses stand on nodes within divided beams, too.
  std::string text = head(model);
  if (model.planar) text += "planar: true\n";
  if (model.gravity) {
    text += with_comment("gravity: " + vector_of(*model.gravity, model.planar),
                         lines_of(model.gravity_lines));
  }
  if (model.modal_damping > 0) {
    text += with_comment("modal_damping: " + shortest_digits(model.modal_damping),
                         lines_of(model.modal_damping_lines));
  }
  const bool moves = std::any_of(model.motions.begin(), model.motions.end(), [](const Motion& m) {
    return m.rate != 0 || m.acceleration != 0;
  });
  if (moves) text += with_comment("operating_point: as_written", "something moves at a given rate");
  text += '\n' + nodes + "\nelements:\n" + elements + '\n' + masses(model, of_elements) + '\n';
  text += supports(model) + prescribed(model) + loads(model);
  text += with_comment("dofs: auto", "DYNE, DYNX and RLSE choose among what moves");
  const std::string in = signals("inputs", model.inputs), out = signals("outputs", model.outputs);
  return text + (in.empty() && out.empty() ? "" : "\n") + in + out;
}

}  // namespace stillframe::tools::spacar
