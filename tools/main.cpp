#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/files/standard_output.hpp"
#include "core/yaml/reader.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

constexpr const char* description =
    "stillframe: active vibration isolation, from a multibody scene to a measured run.\n"
    "A scene is a YAML file (docs/scene.md); config/scenes/ has examples.";

constexpr const char* main_footer =
    "Try:\n"
    "  stillframe modes config/scenes/metrology_frame.yaml\n"
    "  stillframe linearise config/scenes/cart.yaml\n"
    "  stillframe design config/scenes/metrology_frame.yaml\n"
    "  stillframe robustness config/scenes/metrology_frame.yaml \\\n"
    "    --uncertainty config/uncertainty/piezo_frame.yaml\n"
    "  scripts/private_network stillframe run config/scenes/metrology_frame.yaml\n"
    "Every verb has --help, and --json for machines.\n"
    "Exit codes: 0 done; 1 internal error, or output that cannot be written; 2 bad usage or "
    "input;\n"
    "3 refused (an unstable design, a singular model); 4 a run that failed, or did not meet what "
    "its\n"
    "scene accepts, or an import that left something out.";

/// What belongs together, in the order of the work.
struct Group {
  const char* title;
  std::vector<void (*)(cli::Command&, int&)> add;
};
const std::vector<Group> groups{
    {"Model",
     {add_modes, add_equilibrium, add_buckling, add_linearise, add_sigma, add_superelement,
      add_import}},
    {"Control", {add_design, add_feedback, add_budget, add_robustness, add_merge, add_sweep}},
    {"Runs", {add_run, add_batch, add_ctl, add_watch, add_replay, add_rig, add_commission}},
    {"Logs", {add_identify, add_report, add_export}},
};

/// The command line says no more of an unknown verb than that one is required.
void require_known_verb(const cli::Command& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const std::vector<std::string> verbs = app.verbs();
  if (std::find(verbs.begin(), verbs.end(), argv[1]) != verbs.end()) return;
  const std::string near = nearest_name(argv[1], verbs);
  std::string text = "there is no verb '" + std::string(argv[1]) + "'";
  if (!near.empty()) text += " (did you mean '" + near + "'?)";
  std::string allowed;
  for (const std::string& verb : verbs) allowed += (allowed.empty() ? "" : ", ") + verb;
  throw InputError(text + "; allowed: " + allowed);
}

int say(const char* what, const std::string& text, int code) {
  const bool colour = isatty(STDERR_FILENO) != 0;
  // Past std::cerr, which lets no escape through.
  const auto paint = [colour](const char* escape) {
    if (colour) std::fputs(escape, stderr);
  };
  std::cerr << "stillframe: " << std::flush;
  paint("\033[31m");
  std::cerr << what << std::flush;
  paint("\033[0m");
  std::cerr << ": " << text << "\n";
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  cli::Command app(description, "stillframe");
  app.footer(main_footer);
  app.version(STILLFRAME_VERSION);
  app.at_most_one_verb();
  int exit_code = exit_done;
  try {
    for (const Group& group : groups) {
      app.next_group(group.title);
      for (const auto add : group.add) add(app, exit_code);
    }
    require_known_verb(app, argc, argv);
    if (const auto code = app.parse(argc, argv, exit_done, exit_bad_input)) return *code;
    // Alone it says what there is.
    if (!app.has_verb()) std::cout << app.help();
    return exit_code;
  } catch (const Refusal& refusal) {
    return say("refused", refusal.what(), exit_refused);
  } catch (const InputError& error) {
    return say("error", error.what(), exit_bad_input);
  } catch (const Failure& error) {
    return say("error", error.what(), exit_failed);
  } catch (const std::exception& error) {
    return say("error", error.what(), exit_error);
  }
}

}  // namespace stillframe::tools

int main(int argc, char** argv) {
  return stillframe::with_standard_output("stillframe",
                                          [&] { return stillframe::tools::main(argc, argv); });
}
