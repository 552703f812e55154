#include "tools/spacar/light_reader.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/yaml/reader.hpp"
#include "tools/spacar/matlab_script.hpp"
#include "tools/spacar/sections.hpp"
#include "tools/spacar/source_text.hpp"

namespace stillframe::tools::spacar {

namespace {

constexpr std::array pictures{"color", "hide", "opacity"};
/// Options that say how to compute, or what to show.
constexpr std::array how{"filename",         "silent",        "loadsteps", "calcbuck",
                         "calccompl",        "showinputonly", "spavisual", "rigidstress",
                         "stressperelement", "customvis",     "mode",      "simple_mode",
                         "version"};
constexpr std::array axis_names{"x", "y", "z"};
constexpr double coincident = 1e-12;
constexpr Eigen::Index most_in_script = 10000;  ///< of nodes and of elements

template <class Words>
bool contains(const Words& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// A field such as eprops(2).dim, with what reads it.
struct Field {
  std::string text;
  int line = 0;
  const Value* value = nullptr;
};

struct PropertySet {
  int number = 0;
  std::map<std::string, Field> fields;
  std::vector<int> elements;
};

class LightReader {
 public:
  LightReader(const Script& script, const std::string& file) : script_(script), file_(file) {
    const std::size_t slash = file.find_last_of('/');
    model_.given = script_.given;
    model_.title = slash == std::string::npos ? file : file.substr(slash + 1);
    model_.source = file;
    model_.remarks = script.remarks;
    model_.n_statements = script.n_statements;
  }

  Model read() {
    read_nodes();
    read_connectivity();
    read_options();
    read_property_sets();
    read_node_properties();
    make_elements();
    warn_of_further_variables();
    return std::move(model_);
  }

 private:
  const Script& script_;
  const std::string& file_;
  Model model_;
  Eigen::MatrixXd nodes_, elements_;
  int nodes_line_ = 0, elements_line_ = 0;
  std::vector<PropertySet> sets_;
  std::map<int, std::size_t> set_of_;                      ///< of an element
  std::map<int, std::pair<std::set<int>, int>> releases_;  ///< of an element, with its line
  Eigen::Index n_beams_ = 0;
  std::set<int> warping_held_;         ///< numbers of nodes
  std::map<int, int> warping_strips_;  ///< how many flexible ends that warp a node has

  [[noreturn]] void fail(const Field& field, const std::string& found,
                         const std::string& allowed) const {
    refuse(file_, field.line, field.text, found, allowed);
  }

  void leave_out(const Field& field, const std::string& why) {
    model_.remarks.left_out.push_back({.line = field.line, .what = field.text, .why = why});
  }

  static std::string node_name(int number) { return "n" + std::to_string(number); }
  int n_nodes() const { return static_cast<int>(nodes_.rows()); }
  int n_elements() const { return static_cast<int>(elements_.rows()); }

  // --- values of fields

  Eigen::VectorXd numbers(const Field& field) const {
    if (field.value->type != Value::Type::numbers) fail(field, "a text", "are numbers");
    Eigen::VectorXd all(field.value->numbers.reshaped());
    for (const double number : all) {
      if (!(std::abs(number) <= largest_number)) {
        fail(field, "a number that is not finite, or above 1e30", "are finite numbers up to 1e30");
      }
    }
    return all;
  }

  Eigen::VectorXd numbers(const Field& field, Eigen::Index n) const {
    Eigen::VectorXd all = numbers(field);
    if (all.size() != n) {
      fail(field, std::to_string(all.size()) + (all.size() == 1 ? " number" : " numbers"),
           n == 1 ? "is one number" : "are " + std::to_string(n) + " numbers");
    }
    return all;
  }

  double number(const Field& field) const { return numbers(field, 1)(0); }

  double positive(const Field& field) const {
    const double value = number(field);
    if (!(value >= smallest_number)) fail(field, shortest_digits(value), "is a number above 0");
    return value;
  }

  bool is_empty(const Field& field) const {
    return field.value->type == Value::Type::numbers && field.value->numbers.size() == 0;
  }

  bool is_true(const Field& field) const { return !is_empty(field) && number(field) != 0; }

  std::vector<int> whole_numbers(const Field& field, int most, const std::string& of) const {
    std::vector<int> out;
    for (const double value : numbers(field)) {
      if (value != std::floor(value) || value < 1 || value > most) {
        fail(field, shortest_digits(value), "is " + of + " from 1 to " + std::to_string(most));
      }
      out.push_back(static_cast<int>(value));
    }
    return out;
  }

  std::vector<std::string> words(const Field& field) const {
    std::vector<std::string> out;
    if (field.value->type == Value::Type::text) {
      out.push_back(field.value->text);
    } else if (field.value->type == Value::Type::cell) {
      for (const Value& value : field.value->cell) {
        if (value.type != Value::Type::text) fail(field, "a number", "are texts");
        out.push_back(value.text);
      }
    } else if (!is_empty(field)) {
      fail(field, "a number", "are texts");
    }
    return out;
  }

  /// What the script has set of ROOT(index).field; deeper ones (opt.rls(1).def) are not asked for.
  std::map<std::string, Field> fields_of(const std::string& root, int index) {
    std::map<std::string, Field> out;
    for (const Assigned& assigned : script_.fields) {
      const auto& path = assigned.path;
      if (path[0].first != root || std::max(path[0].second, 1) != std::max(index, 1)) continue;
      if (path.size() != 2 || path[1].second > 1) continue;
      out[path[1].first] = {.text = text_of(path), .line = assigned.line, .value = &assigned.value};
    }
    return out;
  }

  static std::string text_of(const std::vector<std::pair<std::string, int>>& path) {
    std::string text;
    for (const auto& [name, index] : path) {
      if (!text.empty()) text += '.';
      text += name;
      if (index > 0) text += '(' + std::to_string(index) + ')';
    }
    return text;
  }

  int largest_index(const std::string& root) const {
    int largest = 0;
    for (const Assigned& assigned : script_.fields) {
      if (assigned.path[0].first != root) continue;
      largest = std::max(largest, std::max(assigned.path[0].second, 1));
    }
    return largest;
  }

  Eigen::MatrixXd table(const std::string& variable, Eigen::Index cols, int& line) const {
    const auto unknown = script_.unknown.find(variable);
    if (unknown != script_.unknown.end()) {
      refuse(file_, unknown->second.first, variable,
             "what is not worked out: " + unknown->second.second, "is a matrix of numbers");
    }
    const auto found = script_.variables.find(variable);
    if (found == script_.variables.end()) {
      refuse(file_, script_.call_line, variable, "no value of it", "is a matrix of numbers");
    }
    line = found->second.second;
    const Value& value = found->second.first;
    const bool fits = value.type == Value::Type::numbers && value.numbers.cols() == cols &&
                      value.numbers.rows() > 0;
    if (!fits) {
      const std::string size = value.type == Value::Type::numbers
                                   ? std::to_string(value.numbers.rows()) + " rows of " +
                                         std::to_string(value.numbers.cols())
                                   : "a text";
      refuse(file_, line, variable, size, "are rows of " + std::to_string(cols) + " numbers");
    }
    if (!(value.numbers.cwiseAbs().maxCoeff() <= largest_number) || value.numbers.hasNaN()) {
      refuse(file_, line, variable, "a number that is not finite, or above 1e30",
             "are finite numbers up to 1e30");
    }
    return value.numbers;
  }

  // --- nodes, elements, options

  void read_nodes() {
    nodes_ = table(script_.arguments[0], 3, nodes_line_);
    if (nodes_.rows() > most_in_script) {
      refuse(file_, nodes_line_, script_.arguments[0], std::to_string(nodes_.rows()) + " nodes",
             "are 10000");
    }
    for (int i = 1; i <= n_nodes(); ++i) {
      model_.nodes.push_back({.name = node_name(i),
                              .position = nodes_.row(i - 1).transpose(),
                              .lines = {nodes_line_}});
    }
  }

  void read_connectivity() {
    elements_ = table(script_.arguments[1], 2, elements_line_);
    if (elements_.rows() > most_in_script) {
      refuse(file_, elements_line_, script_.arguments[1],
             std::to_string(elements_.rows()) + " elements", "are 10000");
    }
    for (const double value : elements_.reshaped()) {
      if (value == std::floor(value) && value >= 1 && value <= n_nodes()) continue;
      refuse(file_, elements_line_, script_.arguments[1], "node " + shortest_digits(value),
             "is a node from 1 to " + std::to_string(n_nodes()));
    }
  }

  void read_release(int index, const Field& field) {
    if (index > n_elements()) {
      fail(field, "element " + std::to_string(index),
           "is one from 1 to " + std::to_string(n_elements()));
    }
    const std::vector<int> modes = whole_numbers(field, 6, "a deformation");
    releases_[index] = {{modes.begin(), modes.end()}, field.line};
  }

  /// nprops, eprops and options are structures; numbers in their place say nothing that is read.
  void note_what_is_no_structure() {
    for (std::size_t i = 2; i < script_.arguments.size(); ++i) {
      const auto found = script_.variables.find(script_.arguments[i]);
      if (found == script_.variables.end()) continue;
      const auto& [value, line] = found->second;
      if (value.type == Value::Type::numbers && value.numbers.size() == 0) continue;
      model_.remarks.left_out.push_back(
          {.line = line, .what = found->first, .why = "is no structure with fields"});
    }
  }

  void read_options() {
    note_what_is_no_structure();
    for (const Assigned& assigned : script_.fields) {
      const auto& path = assigned.path;
      const Field field{.text = text_of(path), .line = assigned.line, .value = &assigned.value};
      const bool extra = std::find(script_.arguments.begin() + 4, script_.arguments.end(),
                                   path[0].first) != script_.arguments.end();
      if (!extra) continue;
      // An older call has the releases as an argument of their own, before the options.
      if (path.size() == 2 && path[1].first == "def") {
        read_release(std::max(path[0].second, 1), field);
      } else if (path.size() == 3 && path[1].first == "rls" && path[2].first == "def") {
        read_release(std::max(path[1].second, 1), field);
      } else {
        read_option(path[1].first, field);
      }
    }
  }

  void read_option(const std::string& name, const Field& field) {
    if (name == "gravity") {
      if (is_empty(field)) return;
      model_.gravity = numbers(field, 3);
      model_.gravity_lines = {field.line};
    } else if (name == "rls" && is_empty(field)) {
      return;
    } else if (name == "transfer") {
      read_transfer(field);
    } else if (contains(how, name)) {
      model_.remarks.no_part.push_back(
          {.line = field.line, .what = field.text, .why = "says how to compute, not what"});
    } else {
      leave_out(field, "is no option that this program translates");
    }
  }

  /// {true, zeta}: linear models are asked for, and zeta is the damping ratio of each mode.
  void read_transfer(const Field& field) {
    const Value& value = *field.value;
    const bool has_ratio = value.type == Value::Type::cell && value.cell.size() > 1;
    if (!has_ratio) return;
    const Value& asked = value.cell[0];
    if (asked.type == Value::Type::numbers && asked.numbers.isZero(0)) return;
    const Value& ratio = value.cell[1];
    if (ratio.type == Value::Type::numbers && ratio.numbers.size() == 1 && ratio.numbers(0) >= 0 &&
        ratio.numbers(0) <= 1) {
      model_.modal_damping = ratio.numbers(0);
      model_.modal_damping_lines = {field.line};
      return;
    }
    leave_out(field, "gives each mode a damping ratio, which a scene has from 0 to 1");
  }

  // --- property sets

  void read_property_sets() {
    const std::string& root = script_.arguments[3];
    for (int i = 1; i <= largest_index(root); ++i) {
      PropertySet set{.number = i, .fields = fields_of(root, i), .elements = {}};
      const auto elems = set.fields.find("elems");
      if (elems == set.fields.end()) {
        for (const auto& [name, field] : set.fields) {
          static_cast<void>(name);
          leave_out(field, "belongs to a set without elems");
        }
        continue;
      }
      set.elements = whole_numbers(elems->second, n_elements(), "an element");
      for (const int element : set.elements) {
        if (!set_of_.try_emplace(element, sets_.size()).second) {
          fail(elems->second, "element " + std::to_string(element) + " in a second set",
               "is one set for each element");
        }
      }
      note_fields(set);
      sets_.push_back(std::move(set));
    }
  }

  void note_fields(const PropertySet& set) {
    for (const auto& [name, field] : set.fields) {
      if (contains(pictures, name)) {
        model_.remarks.no_part.push_back(
            {.line = field.line, .what = field.text, .why = "is drawn"});
      } else if (!contains(std::array{"elems", "emod", "smod", "dens", "cshape", "dim", "orien",
                                      "nbeams", "flex", "cw", "warping", "type"},
                           name)) {
        leave_out(field, "is no property that this program translates");
      }
    }
    if (find(set, "type") != nullptr && !is_hinge(set)) {
      leave_out(set.fields.at("type"), "is a type that is read as a beam; 'hinge' is the other");
    }
    const Field *shape = find(set, "cshape"), *dim = find(set, "dim");
    if (shape != nullptr && dim != nullptr && lower(shape->value->text) == "circ" &&
        numbers(*dim).size() > 1) {
      model_.remarks.approximated.push_back(
          {.line = dim->line, .what = dim->text, .why = "a circle has its first number alone"});
    }
  }

  const Field* find(const PropertySet& set, const std::string& name) const {
    const auto found = set.fields.find(name);
    return found == set.fields.end() || is_empty(found->second) ? nullptr : &found->second;
  }

  const Field& need(const PropertySet& set, const std::string& name) const {
    const Field* field = find(set, name);
    if (field == nullptr) {
      const Field& elems = set.fields.at("elems");
      refuse(file_, elems.line, script_.arguments[3] + "(" + std::to_string(set.number) + ")",
             "no " + name, "is a set with " + name + ", as it is flexible or has a density");
    }
    return *field;
  }

  bool flag(const PropertySet& set, const std::string& name) const {
    const Field* field = find(set, name);
    return field != nullptr && is_true(*field);
  }

  std::set<int> flexible(const PropertySet& set) const {
    const Field* field = find(set, "flex");
    if (field == nullptr) return {};
    const std::vector<int> modes = whole_numbers(*field, 6, "a deformation");
    return {modes.begin(), modes.end()};
  }

  double density(const PropertySet& set) const {
    const Field* field = find(set, "dens");
    if (field == nullptr) return 0;
    const double value = number(*field);
    if (value < 0) fail(*field, shortest_digits(value), "are 0 and more");
    return value;
  }

  Section section(const PropertySet& set, bool stiff) const {
    const Field &shape = need(set, "cshape"), &dim = need(set, "dim");
    const std::vector<std::string> word = words(shape);
    Section out;
    out.circular = word.size() == 1 && lower(word[0]) == "circ";
    if (word.size() != 1 || (!out.circular && lower(word[0]) != "rect")) {
      fail(shape, "'" + (word.empty() ? "" : shown(word[0])) + "'", "are 'rect' and 'circ'");
    }
    const Eigen::VectorXd sizes = out.circular && numbers(dim).size() > 1
                                      ? Eigen::VectorXd(numbers(dim).head(1))
                                      : numbers(dim, out.circular ? 1 : 2);
    if (sizes.minCoeff() < smallest_number) {
      fail(dim, shortest_digits(sizes.minCoeff()), "are lengths above 0");
    }
    out.width = sizes(0);
    out.thickness = out.circular ? sizes(0) : sizes(1);
    out.density = density(set);
    if (stiff) {
      out.e_modulus = positive(need(set, "emod"));
      out.g_modulus = positive(need(set, "smod"));
    }
    return out;
  }

  bool is_hinge(const PropertySet& set) const {
    const Field* type = find(set, "type");
    if (type == nullptr) return false;
    const std::vector<std::string> word = words(*type);
    return word.size() == 1 && lower(word[0]) == "hinge";
  }

  // --- properties of nodes

  void read_node_properties() {
    const std::string& root = script_.arguments[2];
    const int largest = largest_index(root);
    for (int i = 1; i <= largest; ++i) {
      const std::map<std::string, Field> fields = fields_of(root, i);
      if (i > n_nodes() && !fields.empty()) {
        fail(fields.begin()->second, "node " + std::to_string(i),
             "is a node from 1 to " + std::to_string(n_nodes()));
      }
      for (const auto& [name, field] : fields) {
        if (!is_empty(field)) read_node_property(i, name, field);
      }
      read_displacements(i, fields);
    }
  }

  void support(int node, std::vector<std::string> fix, const Field& field) {
    model_.supports.push_back(
        {.node = node_name(node), .fix = std::move(fix), .lines = {field.line}});
  }

  void read_node_property(int i, const std::string& name, const Field& field) {
    if (name.starts_with("fix")) {
      if (is_true(field)) read_fix(i, name, field);
    } else if (name == "force" || name == "force_initial") {
      model_.loads.push_back(
          {.node = node_name(i), .force = numbers(field, 3), .lines = {field.line}});
    } else if (name == "moment" || name == "moment_initial") {
      model_.loads.push_back(
          {.node = node_name(i), .torque = numbers(field, 3), .lines = {field.line}});
    } else if (name == "mass") {
      const double mass = number(field);
      if (mass < 0) fail(field, shortest_digits(mass), "are 0 and more");
      model_.masses.push_back({.node = node_name(i), .mass = mass, .lines = {field.line}});
    } else if (name == "mominertia") {
      const Eigen::VectorXd J = numbers(field, 6);
      Mass mass{.node = node_name(i), .lines = {field.line}};
      mass.inertia << J(0), J(1), J(2), J(1), J(3), J(4), J(2), J(4), J(5);
      model_.masses.push_back(std::move(mass));
    } else if (name == "transfer_in" || name == "transfer_out") {
      read_signals(i, field, name == "transfer_in");
    } else if (name.starts_with("rot")) {
      leave_out(field, "moves a rotation in space, and a scene has none to prescribe");
    } else if (!name.starts_with("displ_")) {
      leave_out(field, "is no property that this program translates");
    }
  }

  void read_fix(int i, const std::string& name, const Field& field) {
    if (name == "fix" || name == "fix_warp") warping_held_.insert(i);
    if (name == "fix") {
      support(i, {"x", "y", "z", "rotation"}, field);
    } else if (name == "fix_pos") {
      support(i, {"x", "y", "z"}, field);
    } else if (name == "fix_orien") {
      support(i, {"rotation"}, field);
    } else if (name == "fix_x" || name == "fix_y" || name == "fix_z") {
      support(i, {name.substr(4)}, field);
    } else if (name != "fix_warp") {
      leave_out(field, "is no property that this program translates");
    }
  }

  /// displ_initial_x, and displ_x that is added over the steps: the scene has the end of them.
  void read_displacements(int i, const std::map<std::string, Field>& fields) {
    std::set<std::string> known;
    for (const char* axis : axis_names) {
      Motion motion;
      motion.node = node_name(i);
      motion.along = axis;
      for (const char* kind : {"displ_initial_", "displ_"}) {
        const std::string name = std::string(kind) + axis;
        known.insert(name);
        const auto found = fields.find(name);
        if (found == fields.end() || is_empty(found->second)) continue;
        motion.value += number(found->second);
        motion.lines.insert(found->second.line);
      }
      if (!motion.lines.empty()) model_.motions.push_back(std::move(motion));
    }
    for (const auto& [name, field] : fields) {
      if (name.starts_with("displ_") && !known.contains(name)) {
        leave_out(field, "is no property that this program translates");
      }
    }
  }

  void read_signals(int i, const Field& field, bool in) {
    for (const std::string& word : words(field)) {
      const std::size_t bar = word.find_last_of('_');
      const std::string kind = word.substr(0, bar),
                        axis = bar == std::string::npos ? "" : word.substr(bar + 1);
      const std::map<std::string, std::string> quantities =
          in ? std::map<std::string, std::string>{{"force", "force"}}
             : std::map<std::string, std::string>{{"displ", "position"}, {"veloc", "velocity"}};
      const auto quantity = quantities.find(kind);
      if (quantity == quantities.end() || !contains(axis_names, axis)) {
        leave_out(field, "'" + shown(word) + "' is no signal that this program translates");
        continue;
      }
      (in ? model_.inputs : model_.outputs)
          .push_back({.name = word + "_" + node_name(i),
                      .quantity = quantity->second,
                      .of = node_name(i),
                      .along = axis,
                      .lines = {field.line}});
    }
  }

  // --- elements

  int end_of(int element, int side) const { return static_cast<int>(elements_(element - 1, side)); }

  void make_elements() {
    for (const PropertySet& set : sets_) {
      if (!flag(set, "warping")) continue;
      const bool rigid = flexible(set).empty();
      for (const int element : set.elements) {
        for (const int side : {0, 1}) {
          // A rigid body does not warp, and so holds what is fixed to it.
          if (rigid) warping_held_.insert(end_of(element, side));
          if (!rigid) ++warping_strips_[end_of(element, side)];
        }
      }
    }
    for (int i = 1; i <= n_elements(); ++i) {
      const auto set = set_of_.find(i);
      make_element(i, set == set_of_.end() ? nullptr : &sets_[set->second]);
    }
  }

  void make_element(int i, const PropertySet* set) {
    Element element;
    element.name = "e" + std::to_string(i);
    element.p = node_name(end_of(i, 0));
    element.q = node_name(end_of(i, 1));
    element.lines = {elements_line_};
    const Eigen::Vector3d along =
        nodes_.row(end_of(i, 1) - 1).transpose() - nodes_.row(end_of(i, 0) - 1).transpose();
    const bool hinge = set != nullptr && is_hinge(*set);
    if (!hinge && along.norm() <= coincident) {
      refuse(file_, elements_line_, script_.arguments[1],
             "element " + std::to_string(i) + " between nodes at one position",
             "are nodes that are apart");
    }
    if (hinge) {
      make_hinge(std::move(element), *set, i);
      return;
    }
    std::set<int> released;
    if (const auto release = releases_.find(i); release != releases_.end()) {
      released = release->second.first;
      element.lines.insert(release->second.second);
    }
    if (set != nullptr) read_set(element, *set, along);
    add_element(std::move(element), released);
  }

  void make_hinge(Element element, const PropertySet& set, int i) {
    element.kind = Kind::hinge;
    element.flexible = {1};
    element.direction = direction(set);
    if (!element.direction) need(set, "orien");
    const double apart = (model_.node(element.p).position - model_.node(element.q).position).norm();
    if (apart > coincident) {
      refuse(file_, elements_line_, script_.arguments[1],
             "hinge " + std::to_string(i) + " between nodes that are apart",
             "are nodes at one position");
    }
    element.lines.insert(set.fields.at("elems").line);
    model_.elements.push_back(std::move(element));
  }

  std::optional<Eigen::Vector3d> direction(const PropertySet& set) const {
    const Field* orien = find(set, "orien");
    if (orien == nullptr) return std::nullopt;
    const Eigen::Vector3d vector = numbers(*orien, 3);
    if (vector.norm() < smallest_number) {
      fail(*orien, "a direction of zero length", "is one of any other length");
    }
    return vector;
  }

  void read_set(Element& element, const PropertySet& set, const Eigen::Vector3d& along) {
    element.lines.insert(set.fields.at("elems").line);
    element.flexible = flexible(set);
    const bool stiff = !element.flexible.empty(), heavy = density(set) > 0;
    element.direction = direction(set);
    if (element.direction &&
        along.cross(*element.direction).norm() <= 1e-9 * along.norm() * element.direction->norm()) {
      const Field& orien = set.fields.at("orien");
      if (stiff || heavy) {
        fail(orien, "a direction along " + element.name, "is one across the elements of the set");
      }
      element.direction.reset();
    }
    read_parts(element, set, stiff);
    if (stiff || heavy) {
      const Section its = section(set, stiff);
      // A strip needs to know which way it is flat; the default of SPACAR Light is y.
      if (!element.direction && !its.circular) element.direction = Eigen::Vector3d::UnitY();
      if (!element.direction) element.direction = along.unitOrthogonal();
      if (along.cross(*element.direction).norm() <= 1e-9 * along.norm()) need(set, "orien");
      if (stiff) element.stiffness = section_stiffness(its);
      if (heavy) element.inertia = section_inertia(its);
      if (stiff) read_warping(element, set, its, along.norm());
    }
  }

  void read_parts(Element& element, const PropertySet& set, bool stiff) {
    const Field* n = find(set, "nbeams");
    if (n == nullptr || !stiff) return;
    static_cast<void>(number(*n));
    element.n_parts = whole_numbers(*n, 1000, "a number of beams").at(0);
    n_beams_ += element.n_parts;
    if (n_beams_ > most_in_script) fail(*n, "more than 10000 beams in all", "are 10000");
  }

  /// Warping is held where a node is fixed, and where a rigid body is that does not warp. The older
  /// `cw` holds it at both ends.
  void read_warping(Element& element, const PropertySet& set, const Section& its, double length) {
    const bool warps = flag(set, "warping"), held_by_set = flag(set, "cw");
    if (!warps && !held_by_set) return;
    int n_held = held_by_set ? 2 : 0;
    bool goes_on = false;
    for (const std::string& end : {element.p, element.q}) {
      const int node = std::stoi(end.substr(1));
      if (!held_by_set && warping_held_.contains(node)) ++n_held;
      if (!held_by_set && !warping_held_.contains(node) && warping_strips_[node] > 1)
        goes_on = true;
    }
    element.torsion_factor =
        warping_factor(element.stiffness[1], section_warping(its), length, n_held);
    goes_on = goes_on || (element.n_parts > 1 && element.torsion_factor > 1);
    const Field& field = set.fields.at(warps ? "warping" : "cw");
    std::string why = "GJ of " + element.name + " is " + shortest_digits(element.torsion_factor) +
                      " times that of free torsion, as " + std::to_string(n_held) +
                      (n_held == 1 ? " end cannot warp" : " ends cannot warp");
    if (goes_on) why += into_neighbour;
    auto& remarks = goes_on ? model_.remarks.left_out : model_.remarks.approximated;
    if (warps) remarks.push_back({.line = field.line, .what = field.text, .why = why});
  }

  /// SPACAR Light releases in the last beam of an element alone.
  void add_element(Element element, const std::set<int>& released) {
    const bool further = std::any_of(released.begin(), released.end(),
                                     [&](int mode) { return !element.flexible.contains(mode); });
    if (further && element.n_parts > 1) {
      const Node &p = model_.node(element.p), &q = model_.node(element.q);
      const int n = element.n_parts;
      const std::string between = element.name + "_last";
      const Eigen::Vector3d at = p.position + (q.position - p.position) * (n - 1) / n;
      model_.nodes.push_back({.name = between, .position = at, .lines = element.lines});
      Element last = element;
      last.name = between;
      last.p = between;
      last.n_parts = 1;
      last.flexible.insert(released.begin(), released.end());
      element.q = between;
      element.n_parts = n - 1;
      model_.elements.push_back(std::move(element));
      model_.elements.push_back(std::move(last));
      return;
    }
    element.flexible.insert(released.begin(), released.end());
    model_.elements.push_back(std::move(element));
  }

  /// Fields of the call's variables that no reader above asked for: nprops(1).a.b and the like.
  void warn_of_further_variables() {
    for (const Assigned& assigned : script_.fields) {
      const auto& path = assigned.path;
      const bool ours =
          path[0].first == script_.arguments[2] || path[0].first == script_.arguments[3];
      if (!ours || (path.size() == 2 && path[1].second <= 1)) continue;
      model_.remarks.left_out.push_back({.line = assigned.line,
                                         .what = text_of(path),
                                         .why = "is no field that this program translates"});
    }
  }
};

}  // namespace

Model model_of_light(const std::vector<std::string>& lines, const std::string& name,
                     const std::vector<std::string>& given) {
  const Script script = run_script(lines, name, given);
  return LightReader(script, name).read();
}

}  // namespace stillframe::tools::spacar
