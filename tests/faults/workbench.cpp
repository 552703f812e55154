#include "tests/faults/workbench.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/faults/process.hpp"

namespace stillframe::faults {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  return text.str();
}

/// Replaces every occurrence; errors unless there are n of them.
void replace(std::string& text, const std::string& from, const std::string& to, int n) {
  int found = 0;
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
    ++found;
  }
  if (found != n) {
    throw std::runtime_error("'" + from + "' stands " + std::to_string(found) + " times, not " +
                             std::to_string(n));
  }
}

/// The quiet half of the recording of config/floors/vc_d.yaml, without its distant earthquake: a
/// peak that is due to that would make any ratio look good.
std::string floor_text(const fs::path& config) {
  std::string text = text_of(config / "floors/vc_d.yaml");
  replace(text, "start_s: 0", "start_s: 160", 1);
  replace(text, "file: ", "file: " + (config / "floors/").string(), 1);
  return text;
}

std::string scene_text(const fs::path& config, double leg_damping) {
  std::string text = text_of(config / "scenes/metrology_frame.yaml");
  if (leg_damping > 0) {
    replace(text, "stiffness: 3.95e6}",
            "stiffness: 3.95e6, damping: " + std::to_string(leg_damping) + "}", 6);
  }
  replace(text, "../floors/vc_d.yaml", "floor.yaml", 1);
  replace(text, "../controllers/", (config / "controllers/").string(), 1);
  return text;
}

}  // namespace

Workbench::Workbench(double leg_damping) {
  const fs::path config = fs::path(STILLFRAME_SOURCE_DIR) / "config";
  std::ofstream(folder_ / "floor.yaml") << floor_text(config);
  std::ofstream(scene()) << scene_text(config, leg_damping);
  Process design({std::string(STILLFRAME_BIN_DIR) + "/stillframe", "design", scene().string(),
                  "--out", gains().string()},
                 folder_ / "design.txt");
  if (design.wait(60) != 0) throw std::runtime_error("stillframe design: " + design.said());
  passive_ = std::make_unique<PassiveFrame>(scene());
}

Workbench::~Workbench() = default;

std::vector<Accelerations> Workbench::passive(std::int64_t n) {
  const std::lock_guard lock(mutex_);
  const auto& all = passive_->samples(n);
  return {all.begin(), all.begin() + n};
}

std::vector<Accelerations> Workbench::held_from(const std::vector<Forces>& applied,
                                                std::int64_t from, std::int64_t n) {
  const std::lock_guard lock(mutex_);
  return passive_->held_from(applied, from, n);
}

}  // namespace stillframe::faults
