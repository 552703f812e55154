#include "controller/latch.hpp"

#include <array>
#include <cctype>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <tuple>
#include <utility>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "core/yaml/quoted.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe::controller {

namespace fs = std::filesystem;

namespace {

/// none if there is no fault of that name.
Fault fault_named(const std::string& name) {
  for (std::int32_t i = 1;; ++i) {
    const std::string_view text = to_text(static_cast<Fault>(i));
    if (text == "unknown") return Fault::none;
    if (text == name) return static_cast<Fault>(i);
  }
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

/// Whether there is a file. Where that cannot be found out there may be one that says stop.
bool is_there(const fs::path& file) {
  std::error_code error;
  const bool there = fs::exists(file, error);
  if (!error) return there;
  throw InputError(file.string() + ": cannot be looked for (" + error.message() +
                   "), so it is not known whether a fault is latched; make its folder readable, "
                   "name another place with --latch, or say with --reset that nothing is left to "
                   "mend");
}

std::pair<Fault, std::string> read(const fs::path& file) {
  const auto root = YamlReader::from_file(file);
  root.allow_only({"fault", "leg", "run_id", "since"});
  const auto value = root.require("fault");
  const Fault fault = fault_named(value.text());
  if (fault == Fault::none) {
    value.fail("found '" + value.text() +
               "', allowed is a fault of docs/safety.md; --reset says that its cause is mended");
  }
  const auto leg = root.find("leg");
  return {fault, leg ? leg->text() : ""};
}

}  // namespace

Latch::Latch(fs::path file, Background& disk, Warn warn, bool clear_at_once)
    : file_(std::move(file)), disk_(disk), warn_(std::move(warn)) {
  if (clear_at_once) {
    clear();
  } else if (!file_.empty() && is_there(file_)) {
    std::tie(fault_, leg_) = read(file_);
  }
}

void Latch::hold(Fault fault, std::int64_t run_id, const std::string& leg) {
  fault_ = fault;
  leg_ = leg;
  if (file_.empty()) return;
  const std::string text =
      "# A fault that only a person ends: mend its cause, then `stillframe ctl reset`, or\n"
      "# stillframe-controller --reset.\nfault: " +
      std::string(to_text(fault)) + (leg.empty() ? "" : "\nleg: " + quoted(leg)) +
      "\nrun_id: " + std::to_string(run_id) + "\nsince: " + utc_now() + "\n";
  disk_.give([file = file_, warn = warn_, text] {
    try {
      if (file.has_parent_path()) fs::create_directories(file.parent_path());
      write_whole_file(file, text);
    } catch (const std::exception& error) {
      warn("the latched fault will not outlive this process: " + std::string(error.what()));
    }
  });
}

void Latch::clear() {
  fault_ = Fault::none;
  leg_.clear();
  if (file_.empty()) return;
  disk_.give([file = file_, warn = warn_] {
    std::error_code error;
    fs::remove(file, error);
    if (error) warn(file.string() + ": cannot be removed: " + error.message());
  });
}

fs::path default_latch_file(const std::string& scene_title) {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder;
  // A relative one is to be ignored, says the XDG Base Directory Specification.
  if (state != nullptr && *state == '/') {
    folder = state;
  } else if (home != nullptr && *home == '/') {
    folder = fs::path(home) / ".local/state";
  } else {
    return {};
  }
  // With room left for what a file is called while it is written; 255 bytes are the most.
  constexpr std::size_t longest_title = 200;
  std::string name = "latch-";
  for (const char c : scene_title.substr(0, longest_title)) {
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  }
  return folder / "stillframe" / (name + ".yaml");
}

}  // namespace stillframe::controller
