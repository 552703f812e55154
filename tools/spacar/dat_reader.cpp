#include "tools/spacar/dat_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <string_view>
#include <tuple>

#include "core/yaml/reader.hpp"
#include "tools/spacar/dat_nodes.hpp"
#include "tools/spacar/dat_records.hpp"
#include "tools/spacar/sections.hpp"

namespace stillframe::tools::spacar {

namespace {

/// How an element keyword goes: its nodes in the order of the file, p for a position, r for an
/// orientation, w for what warps, and how many deformations it has.
struct ElementForm {
  std::string_view keyword;
  Kind kind;
  bool planar;
  std::string_view nodes;
  bool has_direction;
  int n_deformations;
};
constexpr std::array element_forms{
    ElementForm{"BEAM", Kind::beam, false, "prpr", true, 6},
    ElementForm{"BEAMW", Kind::beam, false, "prwprw", true, 6},
    ElementForm{"PLBEAM", Kind::beam, true, "prpr", false, 3},
    ElementForm{"TRUSS", Kind::truss, false, "pp", false, 1},
    ElementForm{"PLTRUSS", Kind::truss, true, "pp", false, 1},
    ElementForm{"HINGE", Kind::hinge, false, "rr", true, 3},
    ElementForm{"PLHINGE", Kind::hinge, true, "rr", false, 1},
    ElementForm{"PLTOR", Kind::hinge, true, "rr", false, 1},
    ElementForm{"RBEAM", Kind::rigid_arm, false, "prp", true, 0},
    ElementForm{"PLRBEAM", Kind::rigid_arm, true, "prp", false, 0},
    ElementForm{"PINBODY", Kind::rigid_arm, false, "prp", false, 0},
};
/// Elements of SPACAR that a scene has nothing for.
constexpr std::array other_elements{"BELT",    "PLBELT", "GEAR", "PLGEAR", "WHEEL",
                                    "PLWHEEL", "SLIDER", "TUBE", "PLTUBE"};
constexpr std::array no_part{"OUTLEVEL", "TIMESTEP",      "ITERSTEP", "MAXTIMESTEP",
                             "RESTART",  "VISUALIZATION", "TITLE"};

const ElementForm* form_of(const std::string& keyword) {
  const auto* found =
      std::find_if(element_forms.begin(), element_forms.end(),
                   [&](const ElementForm& form) { return form.keyword == keyword; });
  return found == element_forms.end() ? nullptr : found;
}

template <class Names>
bool is_among(const Names& names, const std::string& word) {
  return std::find(names.begin(), names.end(), word) != names.end();
}

constexpr std::array<const char*, 3> axes{"x", "y", "z"};

class DatReader {
 public:
  explicit DatReader(const DatFile& file) : file_(file), nodes_(model_) {}

  Model read() {
    model_.source = file_.name;
    const std::size_t slash = file_.name.find_last_of('/');
    model_.title = slash == std::string::npos ? file_.name : file_.name.substr(slash + 1);
    find_plane();
    for (const Record& record : file_.records) read_node(record);
    // Rigid bodies first: they carry an orientation to where others look for it; hinges last.
    for (const Kind kind : {Kind::rigid_arm, Kind::beam, Kind::truss, Kind::hinge}) {
      for (const Record& record : file_.records) read_element_nodes(record, kind);
    }
    nodes_.make_nodes();
    for (const Record& record : file_.records) read_element(record);
    for (const Record& record : file_.records) read_rest(record);
    stiffen_by_warping();
    note_directions();
    if (file_.first_line_of_pictures > 0) {
      model_.remarks.no_part.push_back({.line = file_.first_line_of_pictures,
                                        .what = "what follows END END",
                                        .why = "is of Spavisual, which draws"});
    }
    model_.n_statements = static_cast<int>(file_.records.size());
    return std::move(model_);
  }

 private:
  const DatFile& file_;
  Model model_;
  DatNodes nodes_;
  std::map<int, std::size_t> elements_;  ///< number to place in model_.elements
  std::map<int, int> n_deformations_;
  std::map<int, std::pair<int, int>> warping_ends_;  ///< of a BEAMW, its nodes that warp
  std::set<int> held_warping_;
  std::set<int> untranslated_;  ///< numbers of elements that a scene has nothing for
  std::map<std::pair<int, int>, std::size_t> moved_nodes_, moved_elements_;
  std::set<std::pair<std::string, int>> said_of_nodes_;  ///< XM, XF and DELXF with their nodes
  std::set<std::size_t> started_;  ///< motions that an INPUTX or INPUTE of the dynamics begins

  int dimensions() const { return model_.planar ? 2 : 3; }

  void leave_out(const Record& record, const std::string& why) {
    std::string what = record.keyword;
    for (const std::string& word : record.words) {
      what += ' ';
      what += word;
    }
    model_.remarks.left_out.push_back({.line = record.line, .what = what, .why = why});
  }

  void find_plane() {
    const Record *planar = nullptr, *spatial = nullptr;
    for (const Record& record : file_.records) {
      const ElementForm* form = form_of(record.keyword);
      if (form == nullptr) continue;
      (form->planar ? planar : spatial) = &record;
    }
    if (planar == nullptr && spatial == nullptr) {
      refuse(file_.name, file_.records.empty() ? 1 : file_.records.front().line, "elements",
             "none that a scene has", "are BEAM, TRUSS, HINGE, RBEAM, and PL before each");
    }
    if (planar != nullptr && spatial != nullptr) {
      refuse(file_.name, planar->line, planar->keyword,
             "beside " + spatial->keyword + " of line " + std::to_string(spatial->line),
             "are planar elements alone, or spatial ones");
    }
    model_.planar = planar != nullptr;
  }

  void read_node(const Record& record) {
    if (record.keyword != "X" || record.block != 0) return;
    const auto n = static_cast<std::size_t>(dimensions());
    require_count(file_, record, 1 + n, 1 + n,
                  model_.planar ? "are a node, x and y" : "are a node, x, y and z");
    const int number = whole_number(file_, record, 0);
    if (nodes_.is_placed(number)) {
      refuse(file_.name, record.line, "X", "node " + std::to_string(number) + " a second time",
             "is one position for each");
    }
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      at(static_cast<Eigen::Index>(i)) = real_number(file_, record, 1 + i);
    }
    nodes_.place(number, at, record.line);
  }

  /// The nodes an element names. Of a rigid arm four may be named, then it is a beam without
  /// flexible deformations.
  std::vector<int> nodes_of(const Record& record, const ElementForm& form) const {
    std::size_t n = form.nodes.size();
    const std::size_t n_words = record.words.size(), tail = form.has_direction ? 3 : 0;
    if (form.kind == Kind::rigid_arm && (n_words == n + 2 || n_words == n + 2 + tail)) ++n;
    if (n_words != n + 1 && n_words != n + 1 + tail) {
      std::string allowed = "are its number and " + std::to_string(form.nodes.size()) + " nodes";
      if (tail > 0) allowed += ", and a direction of three numbers";
      require_count(file_, record, n_words + 1, n_words + 1, allowed);
    }
    std::vector<int> out;
    for (std::size_t i = 1; i <= n; ++i) out.push_back(whole_number(file_, record, i));
    return out;
  }

  static std::string order_of(const ElementForm& form, std::size_t n_nodes) {
    return form.kind == Kind::rigid_arm && n_nodes == 4 ? "prpr" : std::string(form.nodes);
  }

  void require_kinds(const Record& record, const std::vector<int>& numbers,
                     const std::string& order) const {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (order[i] == 'p' && !nodes_.is_placed(numbers[i])) {
        refuse(file_.name, record.line, record.keyword,
               "node " + std::to_string(numbers[i]) + ", which has no X",
               "is a position that an X gives");
      }
      if (order[i] != 'p' && nodes_.is_placed(numbers[i])) {
        refuse(file_.name, record.line, record.keyword,
               "node " + std::to_string(numbers[i]) + " as an orientation",
               "is a node that is no position: an X gives it one");
      }
    }
  }

  void read_element_nodes(const Record& record, Kind kind) {
    const ElementForm* form = record.block == 0 ? form_of(record.keyword) : nullptr;
    if (form == nullptr || form->kind != kind) return;
    const std::vector<int> numbers = nodes_of(record, *form);
    const std::string order = order_of(*form, numbers.size());
    require_kinds(record, numbers, order);
    bool one_place = true;
    if (kind == Kind::hinge) {
      one_place = nodes_.join(numbers[0], numbers[1]) || waits_for_later(numbers);
    } else if (order == "prp") {
      one_place = nodes_.carry(numbers[0], numbers[1], numbers[2]);
    } else {
      for (std::size_t i = 0; i + 1 < order.size(); ++i) {
        if (order[i] == 'p' && order[i + 1] == 'r') {
          one_place = nodes_.pair(numbers[i], numbers[i + 1]) && one_place;
        }
      }
    }
    if (!one_place) {
      leave_out(record, "joins orientations of two positions, and a node of a scene has one");
      untranslated_.insert(whole_number(file_, record, 0));
    }
    if (!waiting_.empty()) settle_waiting();
  }

  /// Hinges between orientations that no element before them has put anywhere.
  std::vector<std::vector<int>> waiting_;
  bool waits_for_later(const std::vector<int>& numbers) {
    if (nodes_.is_orientation(numbers[0]) || nodes_.is_orientation(numbers[1])) return false;
    waiting_.push_back(numbers);
    return true;
  }
  void settle_waiting() {
    for (bool settled = true; settled;) {
      settled = false;
      for (std::size_t i = 0; i < waiting_.size(); ++i) {
        if (!nodes_.join(waiting_[i][0], waiting_[i][1])) continue;
        waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
        settled = true;
        break;
      }
    }
  }

  void read_element(const Record& record) {
    if (record.block != 0) return;
    if (is_among(other_elements, record.keyword)) {
      leave_out(record, "a scene has no such element");
      if (!record.words.empty()) untranslated_.insert(whole_number(file_, record, 0));
      return;
    }
    const ElementForm* form = form_of(record.keyword);
    if (form == nullptr) return;
    const int number = whole_number(file_, record, 0);
    if (untranslated_.contains(number)) return;
    if (elements_.contains(number)) {
      refuse(file_.name, record.line, record.keyword,
             "element " + std::to_string(number) + " a second time", "is one element of a number");
    }
    const std::vector<int> numbers = nodes_of(record, *form);
    Element element;
    element.kind = form->kind;
    element.name = "e" + std::to_string(number);
    element.lines = {record.line};
    if (!name_ends(element, *form, numbers, record)) return;
    read_direction(element, *form, record, 1 + numbers.size());
    if (element.kind != Kind::hinge) require_length(element, record);
    n_deformations_[number] = form->n_deformations;
    elements_[number] = model_.elements.size();
    model_.elements.push_back(std::move(element));
  }

  bool name_ends(Element& element, const ElementForm& form, const std::vector<int>& numbers,
                 const Record& record) {
    const std::string order = order_of(form, numbers.size());
    if (form.kind == Kind::hinge) {
      if (!nodes_.is_orientation(numbers[0]) || !nodes_.is_orientation(numbers[1])) {
        leave_out(record, "joins orientations that no other element has, so they are nowhere");
        untranslated_.insert(whole_number(file_, record, 0));
        return false;
      }
      std::tie(element.p, element.q) = nodes_.of_hinge(numbers[0], numbers[1]);
    } else if (form.kind == Kind::truss) {
      element.p = nodes_.of_position(numbers[0]);
      element.q = nodes_.of_position(numbers[1]);
    } else {
      element.p = nodes_.of_pair(numbers[0], numbers[1]);
      const std::size_t q = order.find('p', 1);
      element.q = nodes_.of_pair(numbers[q], numbers[order == "prp" ? 1 : q + 1]);
      if (order == "prwprw")
        warping_ends_[whole_number(file_, record, 0)] = {numbers[2], numbers[5]};
    }
    return true;
  }

  void read_direction(Element& element, const ElementForm& form, const Record& record,
                      std::size_t from) {
    if (!form.has_direction) return;
    if (record.words.size() > from) {
      element.direction =
          Eigen::Vector3d(real_number(file_, record, from), real_number(file_, record, from + 1),
                          real_number(file_, record, from + 2));
      if (element.direction->norm() == 0) {
        refuse(file_.name, record.line, record.keyword, "a direction of zero length",
               "is one of any other length");
      }
    } else if (form.kind == Kind::hinge) {
      element.direction = Eigen::Vector3d::UnitX();
      leave_out(record, "names no axis; the scene has x");
    }
  }

  /// A beam that is flexible, or has rotary inertia, has to know which way its section lies.
  void note_directions() {
    for (Element& element : model_.elements) {
      if (element.kind != Kind::beam || model_.planar || element.direction) continue;
      element.direction = across(element);
      if (element.flexible.empty() && element.inertia.size() < 2) continue;
      model_.remarks.left_out.push_back(
          {.line = *element.lines.begin(),
           .what = element.name,
           .why = "names no direction of y'; the scene has one across it"});
    }
  }

  /// BEAMW: constrained warping, as a larger stiffness of torsion.
  void stiffen_by_warping() {
    std::map<int, int> strips;
    for (const auto& [number, ends] : warping_ends_) {
      const Element& element = model_.elements[elements_.at(number)];
      if (element.flexible.empty()) continue;
      ++strips[ends.first];
      ++strips[ends.second];
    }
    for (const auto& [number, ends] : warping_ends_) {
      Element& element = model_.elements[elements_.at(number)];
      if (element.flexible.empty() || element.stiffness.size() < 7) continue;
      const int n_held = (held_warping_.contains(ends.first) ? 1 : 0) +
                         (held_warping_.contains(ends.second) ? 1 : 0);
      const double l = (model_.node(element.q).position - model_.node(element.p).position).norm();
      element.torsion_factor =
          warping_factor(element.stiffness[1], element.stiffness[6], l, n_held);
      bool goes_on = false;
      for (const int end : {ends.first, ends.second}) {
        goes_on = goes_on || (strips[end] > 1 && !held_warping_.contains(end));
      }
      std::string why = "its GJ is " + shortest_digits(element.torsion_factor) +
                        " times that of free torsion, as " + std::to_string(n_held) +
                        (n_held == 1 ? " end cannot warp" : " ends cannot warp");
      if (goes_on) why += into_neighbour;
      auto& remarks = goes_on ? model_.remarks.left_out : model_.remarks.approximated;
      remarks.push_back(
          {.line = *element.lines.begin(), .what = "BEAMW " + std::to_string(number), .why = why});
    }
  }

  Eigen::Vector3d across(const Element& element) const {
    const Eigen::Vector3d along =
        (model_.node(element.q).position - model_.node(element.p).position).normalized();
    return std::abs(along.y()) < 0.9 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  }

  void require_length(const Element& element, const Record& record) const {
    if (model_.node(element.p).position != model_.node(element.q).position) return;
    refuse(file_.name, record.line, record.keyword, "two nodes at one position",
           "are nodes that are apart");
  }

  // --- what is said of nodes and elements

  Element* element_of(const Record& record, std::size_t i) {
    const int number = whole_number(file_, record, i);
    if (untranslated_.contains(number)) {
      leave_out(record, "belongs to element " + std::to_string(number) + ", which is left out");
      return nullptr;
    }
    const auto found = elements_.find(number);
    if (found == elements_.end()) {
      refuse(file_.name, record.line, record.keyword, "element " + std::to_string(number),
             "is the number of an element of this file");
    }
    // An output is no property of its element.
    if (record.block < 2) model_.elements[found->second].lines.insert(record.line);
    return &model_.elements[found->second];
  }

  int mode_of(const Record& record, std::size_t i, const Element& element) const {
    const int mode = whole_number(file_, record, i);
    const int n = n_deformations_.at(std::stoi(element.name.substr(1)));
    if (mode > n) {
      refuse(file_.name, record.line, record.keyword, "deformation " + std::to_string(mode),
             n == 0 ? "is none: the element is rigid" : "is one from 1 to " + std::to_string(n));
    }
    return mode;
  }

  enum class Coordinate { position, orientation };
  Coordinate coordinate_of(const Record& record, std::size_t i) const {
    const int number = whole_number(file_, record, i);
    if (nodes_.is_placed(number)) return Coordinate::position;
    if (nodes_.is_orientation(number)) return Coordinate::orientation;
    refuse(file_.name, record.line, record.keyword, "node " + std::to_string(number),
           "is a node of this file, with an X or in an element");
  }
  std::string node_of(const Record& record, std::size_t i) const {
    const int number = whole_number(file_, record, i);
    return coordinate_of(record, i) == Coordinate::position ? nodes_.of_position(number)
                                                            : nodes_.of_orientation(number);
  }

  /// The coordinates of a node that stand from the i-th word on; all of them if there is none.
  std::vector<int> coordinates(const Record& record, std::size_t from, Coordinate of) const {
    const int n = of == Coordinate::position ? dimensions() : (model_.planar ? 1 : 4);
    std::vector<int> out;
    for (std::size_t i = from; i < record.words.size(); ++i) {
      out.push_back(whole_number(file_, record, i));
      if (out.back() > n) {
        refuse(file_.name, record.line, record.keyword, "coordinate " + std::to_string(out.back()),
               "is one from 1 to " + std::to_string(n));
      }
    }
    if (out.empty()) {
      for (int i = 1; i <= n; ++i) out.push_back(i);
    }
    return out;
  }

  /// Whether these Euler parameters are the whole rotation: lambda_1 to lambda_3, as lambda_0
  /// follows.
  bool whole_rotation(const std::vector<int>& which) const {
    const auto has = [&](int i) { return std::find(which.begin(), which.end(), i) != which.end(); };
    return model_.planar || (has(2) && has(3) && has(4));
  }

  bool is_warping(const Record& record, std::size_t i) const {
    const int number = whole_number(file_, record, i);
    return std::any_of(warping_ends_.begin(), warping_ends_.end(), [&](const auto& ends) {
      return ends.second.first == number || ends.second.second == number;
    });
  }

  void read_fix(const Record& record) {
    require_count(file_, record, 1, 5, "are a node and its coordinates");
    if (is_warping(record, 0)) {
      // FIX NODE, or the numbers of its coordinates: warping is the one that a beam has.
      for (std::size_t i = 1; i < record.words.size(); ++i) {
        static_cast<void>(whole_number(file_, record, i));
      }
      held_warping_.insert(whole_number(file_, record, 0));
      return;
    }
    const Coordinate of = coordinate_of(record, 0);
    const std::vector<int> which = coordinates(record, 1, of);
    Support support{.node = node_of(record, 0), .fix = {}, .lines = {record.line}};
    if (of == Coordinate::position) {
      for (const int i : which) support.fix.emplace_back(axes.at(static_cast<std::size_t>(i - 1)));
    } else if (whole_rotation(which)) {
      support.fix.emplace_back("rotation");
    } else {
      leave_out(record, "holds single Euler parameters; a scene holds a rotation or leaves it");
      return;
    }
    model_.supports.push_back(std::move(support));
  }

  void move_node(const Record& record) {
    require_count(file_, record, 1, 5, "are a node and its coordinates");
    const Coordinate of = coordinate_of(record, 0);
    const int number = whole_number(file_, record, 0);
    if (of == Coordinate::orientation && !model_.planar) {
      const std::vector<int> which = coordinates(record, 1, of);
      if (!whole_rotation(which)) {
        leave_out(record, "prescribes single Euler parameters, and a scene has none to prescribe");
        return;
      }
      model_.supports.push_back(
          {.node = node_of(record, 0), .fix = {"rotation"}, .lines = {record.line}});
      model_.remarks.approximated.push_back(
          {.line = record.line,
           .what = "INPUTX " + std::to_string(number),
           .why = "a prescribed rotation in space is held as it is in the scene"});
      return;
    }
    for (const int i : coordinates(record, 1, of)) {
      moved_nodes_[{number, i}] = model_.motions.size();
      model_.motions.push_back({.node = node_of(record, 0),
                                .along = of == Coordinate::orientation
                                             ? "rotation"
                                             : axes.at(static_cast<std::size_t>(i - 1)),
                                .element = {},
                                .lines = {record.line}});
    }
  }

  void free_deformations(const Record& record) {
    require_count(file_, record, 1, 7, "are an element and its deformations");
    Element* element = element_of(record, 0);
    if (element == nullptr) return;
    const int number = whole_number(file_, record, 0);
    std::vector<int> modes;
    for (std::size_t i = 1; i < record.words.size(); ++i) {
      modes.push_back(mode_of(record, i, *element));
    }
    if (modes.empty()) {
      modes.resize(static_cast<std::size_t>(n_deformations_.at(number)));
      std::iota(modes.begin(), modes.end(), 1);
    }
    for (const int mode : modes) {
      element->flexible.insert(mode);
      if (record.keyword != "INPUTE") continue;
      element->prescribed.insert(mode);
      moved_elements_[{number, mode}] = model_.motions.size();
      model_.motions.push_back({.node = {},
                                .along = {},
                                .element = element->name,
                                .mode = mode,
                                .lines = {record.line}});
    }
  }

  /// INPUTX or INPUTE of the dynamics: how what is prescribed begins.
  void start_motion(const Record& record) {
    require_count(file_, record, 3, 5,
                  "are a number, a coordinate or deformation, and value, rate and acceleration");
    const bool of_node = record.keyword == "INPUTX";
    const std::pair key{whole_number(file_, record, 0), whole_number(file_, record, 1)};
    if (!of_node && untranslated_.contains(key.first)) {
      leave_out(record, "belongs to an element that is left out");
      return;
    }
    const auto& moved = of_node ? moved_nodes_ : moved_elements_;
    const auto found = moved.find(key);
    if (found == moved.end()) {
      if (of_node && !model_.planar && nodes_.is_orientation(key.first)) {
        leave_out(record, "moves a rotation in space, and a scene has none to prescribe");
        return;
      }
      if (of_node) static_cast<void>(coordinate_of(record, 0));
      if (!of_node && element_of(record, 0) == nullptr) return;
      leave_out(record, "begins a motion that no such keyword of the first block prescribes");
      return;
    }
    Motion& motion = model_.motions[found->second];
    const std::vector<double> numbers = real_numbers(file_, record, 2);
    if (!started_.insert(found->second).second) {
      refuse(file_.name, record.line, record.keyword,
             "a second line for " + record.words[0] + ' ' + record.words[1],
             "is one for each, and DELINPX or DELINPE to add to it");
    }
    // A DELINPX may stand before this line, and is added all the same.
    motion.value += numbers[0];
    if (of_node && motion.along != "rotation") {
      motion.value -= model_.node(motion.node).position(key.second - 1);
    }
    if (numbers.size() > 1) motion.rate = numbers[1];
    if (numbers.size() > 2) motion.acceleration = numbers[2];
    motion.lines.insert(record.line);
  }

  void element_numbers(const Record& record, std::vector<double> Element::*numbers,
                       std::size_t most) {
    require_count(file_, record, 2, 1 + most,
                  "are an element and up to " + std::to_string(most) + " numbers");
    Element* element = element_of(record, 0);
    if (element == nullptr) return;
    if (!(element->*numbers).empty()) {
      refuse(file_.name, record.line, record.keyword, "a second line for " + element->name,
             "is one for each element");
    }
    element->*numbers = real_numbers(file_, record, 1);
  }

  /// ESTIFF, EDAMP, EM and ESIG, with what the element of each kind has of them.
  void read_element_numbers(const Record& record) {
    require_count(file_, record, 1, 8, "are an element and its numbers");
    if (record.words.size() == 1) return;
    const int number = whole_number(file_, record, 0);
    const auto found = elements_.find(number);
    const Kind kind = found == elements_.end() ? Kind::beam : model_.elements[found->second].kind;
    const bool stiff = record.keyword == "ESTIFF";
    std::size_t most = 1;
    if (record.keyword == "EM") {
      if (kind == Kind::hinge || kind == Kind::rigid_arm) {
        leave_out(record, "a scene has no mass of such an element");
        return;
      }
      most = kind == Kind::beam ? (model_.planar ? 2 : 6) : 1;
      element_numbers(record, &Element::inertia, most);
      note_warping_of_straight(record, number, 6);
      return;
    }
    if (kind == Kind::beam && model_.planar) most = stiff || record.keyword == "ESIG" ? 3 : 2;
    if (kind == Kind::beam && !model_.planar) most = stiff ? 7 : (record.keyword == "ESIG" ? 6 : 4);
    if (kind == Kind::hinge && !model_.planar) most = 3;
    if (kind == Kind::rigid_arm) {
      leave_out(record, "the element is rigid");
      return;
    }
    element_numbers(record,
                    stiff                       ? &Element::stiffness
                    : record.keyword == "EDAMP" ? &Element::damping
                                                : &Element::stress,
                    most);
    if (stiff) require_no_negative(record);
    if (stiff && kind == Kind::beam) note_warping_of_straight(record, number, 7);
    if (record.keyword == "EDAMP") require_no_negative(record);
  }

  /// The last number of ESTIFF and of EM is of warping, and only a BEAMW warps: SPACAR's results of
  /// guides of BEAM that have such numbers are those without.
  void note_warping_of_straight(const Record& record, int number, std::size_t i) {
    if (!elements_.contains(number) || warping_ends_.contains(number)) return;
    if (record.words.size() <= i) return;
    if (real_number(file_, record, i) == 0) return;
    model_.remarks.no_part.push_back(
        {.line = record.line,
         .what = record.keyword + ' ' + record.words[0],
         .why = "number " + std::to_string(i) + " is of warping, and a BEAMW alone warps"});
  }

  void require_no_negative(const Record& record) const {
    for (const double value : real_numbers(file_, record, 1)) {
      if (value >= 0) continue;
      refuse(file_.name, record.line, record.keyword, "a negative number", "are 0 and more");
    }
  }

  /// Whether a second line of a keyword for one node is added or takes the place of the first is
  /// not sure, so it is neither.
  void require_first(const Record& record) {
    if (said_of_nodes_.emplace(record.keyword, whole_number(file_, record, 0)).second) return;
    refuse(file_.name, record.line, record.keyword, "a second line for node " + record.words[0],
           "is one for each node");
  }

  void read_mass(const Record& record) {
    require_first(record);
    const Coordinate of = coordinate_of(record, 0);
    Mass mass{.node = node_of(record, 0), .lines = {record.line}};
    if (of == Coordinate::position) {
      require_count(file_, record, 2, 2, "are a node and its mass");
      mass.mass = real_number(file_, record, 1);
      require_no_negative(record);
    } else if (model_.planar) {
      require_count(file_, record, 2, 2, "are a node and its moment of inertia");
      mass.inertia(2, 2) = real_number(file_, record, 1);
      require_no_negative(record);
    } else {
      require_count(file_, record, 7, 7, "are a node and Jxx, Jxy, Jxz, Jyy, Jyz, Jzz");
      const std::vector<double> J = real_numbers(file_, record, 1);
      mass.inertia << J[0], J[1], J[2], J[1], J[3], J[4], J[2], J[4], J[5];
    }
    model_.masses.push_back(std::move(mass));
  }

  /// XF, and DELXF that is added to it over the steps of a static analysis: the scene has the end.
  void read_load(const Record& record) {
    require_first(record);
    const Coordinate of = coordinate_of(record, 0);
    Load load{.node = node_of(record, 0), .lines = {record.line}};
    if (of == Coordinate::position) {
      const auto n = static_cast<std::size_t>(dimensions());
      require_count(file_, record, 1 + n, 1 + n, "are a node and a force");
      for (std::size_t i = 0; i < n; ++i) {
        load.force(static_cast<Eigen::Index>(i)) = real_number(file_, record, 1 + i);
      }
    } else if (model_.planar) {
      require_count(file_, record, 2, 2, "are a node and a moment");
      load.torque.z() = real_number(file_, record, 1);
    } else {
      require_count(file_, record, 4, 5,
                    "are a node and a moment of three numbers, or four of the Euler parameters");
      const std::vector<double> M = real_numbers(file_, record, 1);
      // What is dual to the Euler parameters is twice the moment where these are 1, 0, 0, 0.
      load.torque = M.size() == 3 ? Eigen::Vector3d(M[0], M[1], M[2])
                                  : Eigen::Vector3d(M[1] / 2, M[2] / 2, M[3] / 2);
    }
    model_.loads.push_back(std::move(load));
  }

  void add_to_motion(const Record& record) {
    require_count(file_, record, 3, 3, "are a number, a coordinate or deformation, and a step");
    const bool of_node = record.keyword == "DELINPX";
    const auto& moved = of_node ? moved_nodes_ : moved_elements_;
    const auto found = moved.find({whole_number(file_, record, 0), whole_number(file_, record, 1)});
    if (found == moved.end()) {
      leave_out(record, "is added to what no INPUTX or INPUTE of this scene moves");
      return;
    }
    Motion& motion = model_.motions[found->second];
    motion.value += real_number(file_, record, 2);
    motion.lines.insert(record.line);
  }

  /// STARTDE, STARTDX: where a simulation begins. Zero is the scene as it is written.
  void read_start(const Record& record) {
    if (record.keyword == "STARTDE") {
      require_count(file_, record, 3, 5,
                    "are an element, a deformation, value, rate and acceleration");
    }
    const std::vector<double> numbers =
        real_numbers(file_, record, std::min<std::size_t>(2, record.words.size()));
    const bool still = std::all_of(numbers.begin(), numbers.end(), [](double v) { return v == 0; });
    if (still && record.keyword != "STARTDX") return;
    leave_out(record, "is where a simulation begins; a scene begins in its equilibrium");
  }

  void read_gravity(const Record& record) {
    const auto n = static_cast<std::size_t>(dimensions());
    require_count(file_, record, n, 3, "is an acceleration along each axis");
    if (model_.gravity) {
      refuse(file_.name, record.line, record.keyword, "a second line", "is one");
    }
    for (std::size_t i = n; i < record.words.size(); ++i) {
      if (real_number(file_, record, i) == 0) continue;
      leave_out(record, "has a part across the plane, which a planar scene has not");
    }
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      g(static_cast<Eigen::Index>(i)) = real_number(file_, record, i);
    }
    model_.gravity = g;
    model_.gravity_lines = {record.line};
  }

  // --- inputs and outputs of the linear model

  /// INDEX NODE COORDINATE.
  void node_signal(const Record& record, std::vector<Signal>& signals, const char* of_position,
                   const char* of_rotation) {
    require_count(file_, record, 3, 3, "are an index, a node and a coordinate");
    const Coordinate of = coordinate_of(record, 1);
    Record rest = record;
    rest.words.erase(rest.words.begin());
    const int i = coordinates(rest, 1, of).front();
    if (of == Coordinate::orientation && !model_.planar) {
      leave_out(record, "is of an Euler parameter; a scene has rotations about an axis");
      return;
    }
    const bool turns = of == Coordinate::orientation;
    signals.push_back({.name = record.keyword + "_" + record.words[0],
                       .quantity = turns ? of_rotation : of_position,
                       .of = node_of(record, 1),
                       .along = turns ? "" : axes.at(static_cast<std::size_t>(i - 1)),
                       .lines = {record.line}});
  }

  /// INDEX ELEMENT DEFORMATION.
  void element_signal(const Record& record, std::vector<Signal>& signals, const char* quantity) {
    require_count(file_, record, 3, 3, "are an index, an element and a deformation");
    Element* element = element_of(record, 1);
    if (element == nullptr) return;
    signals.push_back({.name = record.keyword + "_" + record.words[0],
                       .quantity = quantity,
                       .of = element->name,
                       .along = {},
                       .mode = mode_of(record, 2, *element),
                       .lines = {record.line}});
  }

  using Reading = std::function<void(const Record&)>;
  std::map<std::string, Reading> readings(int block) {
    const Reading free = [this](const Record& r) { free_deformations(r); };
    const Reading numbers = [this](const Record& r) { read_element_numbers(r); };
    const Reading load = [this](const Record& r) { read_load(r); };
    const Reading start = [this](const Record& r) { start_motion(r); };
    const Reading step = [this](const Record& r) { add_to_motion(r); };
    const Reading begin = [this](const Record& r) { read_start(r); };
    if (block == 0) {
      return {{"FIX", [this](const Record& r) { read_fix(r); }},
              {"INPUTX", [this](const Record& r) { move_node(r); }},
              {"INPUTE", free},
              {"DYNE", free},
              {"RLSE", free},
              // A coordinate of a node as a dof: the scene's dofs are auto.
              {"DYNX", [this](const Record& r) {
                 require_count(file_, r, 1, 5, "are a node and its coordinates");
                 static_cast<void>(coordinates(r, 1, coordinate_of(r, 0)));
               }}};
    }
    if (block == 1) {
      return {{"ESTIFF", numbers},
              {"EDAMP", numbers},
              {"EM", numbers},
              {"ESIG", numbers},
              {"XF", load},
              {"DELXF", load},
              {"INPUTX", start},
              {"INPUTE", start},
              {"DELINPX", step},
              {"DELINPE", step},
              {"STARTDE", begin},
              {"STARTDX", begin},
              {"XM", [this](const Record& r) { read_mass(r); }},
              {"GRAVITY", [this](const Record& r) { read_gravity(r); }}};
    }
    const auto node_output = [this](const char* of_position, const char* of_rotation) {
      return
          [=, this](const Record& r) { node_signal(r, model_.outputs, of_position, of_rotation); };
    };
    const auto element_output = [this](const char* quantity) {
      return [=, this](const Record& r) { element_signal(r, model_.outputs, quantity); };
    };
    return {
        {"INPUTS", [this](const Record& r) { element_signal(r, model_.inputs, "stress"); }},
        {"INPUTF", [this](const Record& r) { node_signal(r, model_.inputs, "force", "torque"); }},
        {"OUTX", node_output("position", "rotation")},
        {"OUTXP", node_output("velocity", "angular_velocity")},
        {"OUTE", element_output("deformation")},
        {"OUTEP", element_output("deformation_rate")}};
  }

  void read_rest(const Record& record) {
    if (record.keyword == "X" && record.block == 0) return;
    if (record.block == 0 &&
        (form_of(record.keyword) != nullptr || is_among(other_elements, record.keyword))) {
      return;
    }
    if (is_among(no_part, record.keyword)) {
      model_.remarks.no_part.push_back(
          {.line = record.line, .what = record.keyword, .why = "says how to compute, not what"});
      return;
    }
    const std::map<std::string, Reading> all = readings(std::min(record.block, 2));
    const auto found = all.find(record.keyword);
    if (found == all.end()) {
      const bool kinematic = record.keyword == "KINX" || record.keyword == "KINE";
      leave_out(record, kinematic
                            ? "is a coordinate that follows a rolling motion, and a scene has "
                              "none that are no dofs"
                            : "is no keyword that this program translates in this block");
      return;
    }
    if (record.words.empty()) {
      require_count(file_, record, 1, 99, "is a number behind it");
    }
    found->second(record);
  }
};

}  // namespace

Model model_of_dat(const std::vector<std::string>& lines, const std::string& name) {
  const DatFile file = parse_dat(lines, name);
  return DatReader(file).read();
}

}  // namespace stillframe::tools::spacar
