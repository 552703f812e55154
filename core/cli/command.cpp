#include "core/cli/command.hpp"

#include <CLI/CLI.hpp>
#include <cmath>

namespace stillframe::cli {

namespace {

Check check_of(CLI::Validator validator) {
  return Check(std::make_shared<CLI::Validator>(std::move(validator)));
}

Check finite_number(const char* name, bool zero) {
  return check_of(CLI::Validator(
      [zero](std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
            (zero ? value >= 0 : value > 0)) {
          return {};
        }
        return "'" + text + "' is no number " + (zero ? "of 0 or more" : "above 0");
      },
      name));
}

}  // namespace

Check positive_number() { return finite_number("POSITIVE", false); }
Check number_from_zero() { return finite_number("NONNEGATIVE", true); }
Check whole_number(std::int64_t lowest, std::int64_t highest) {
  return check_of(CLI::Range(lowest, highest));
}
Check number_between(double lowest, double highest) {
  return check_of(CLI::Range(lowest, highest));
}
Check one_of(std::vector<std::string> words) { return check_of(CLI::IsMember(std::move(words))); }
Check existing_file() { return check_of(CLI::ExistingFile); }
Check existing_folder() { return check_of(CLI::ExistingDirectory); }

Option Option::required() { return Option(option_->required()); }
Option Option::type_name(const std::string& name) { return Option(option_->type_name(name)); }
Option Option::check(const Check& check) { return Option(option_->check(check.validator())); }
Option Option::show_default() { return Option(option_->capture_default_str()); }
Option Option::default_text(const std::string& text) { return Option(option_->default_str(text)); }
Option Option::delimiter(char between) { return Option(option_->delimiter(between)); }
Option Option::one_each_time() { return Option(option_->allow_extra_args(false)); }
Option Option::optional_value() { return Option(option_->expected(0, 1)); }
Option Option::excludes(Option other) { return Option(option_->excludes(other.option_)); }

Command::Command(const std::string& description, const std::string& name)
    : app_(std::make_shared<CLI::App>(description, name)) {}

Command Command::verb(const std::string& name, const std::string& description) {
  CLI::App* verb = app_->add_subcommand(name, description);
  if (!group_.empty()) verb->group(group_);
  return Command(std::shared_ptr<CLI::App>(app_, verb));
}

void Command::footer(const std::string& text) { app_->footer(text); }
void Command::version(const std::string& text) { app_->set_version_flag("--version", text); }
void Command::at_most_one_verb() { app_->require_subcommand(0, 1); }
void Command::runs(std::function<void()> action) { app_->callback(std::move(action)); }

Option Command::flag(const std::string& name, bool& value, const std::string& help) {
  return Option(app_->add_flag(name, value, help));
}

template <class Value>
Option Command::option(const std::string& name, Value& value, const std::string& help) {
  return Option(app_->add_option(name, value, help));
}

#define STILLFRAME_OPTION(...) \
  template Option Command::option(const std::string&, __VA_ARGS__&, const std::string&)
STILLFRAME_OPTION(double);
STILLFRAME_OPTION(int);
STILLFRAME_OPTION(std::int64_t);
STILLFRAME_OPTION(std::uint64_t);
STILLFRAME_OPTION(std::string);
STILLFRAME_OPTION(std::filesystem::path);
STILLFRAME_OPTION(std::optional<double>);
STILLFRAME_OPTION(std::optional<int>);
STILLFRAME_OPTION(std::optional<std::int64_t>);
STILLFRAME_OPTION(std::optional<std::string>);
STILLFRAME_OPTION(std::optional<std::filesystem::path>);
STILLFRAME_OPTION(std::vector<std::string>);
STILLFRAME_OPTION(std::vector<std::filesystem::path>);
#undef STILLFRAME_OPTION

std::vector<std::string> Command::verbs() const {
  std::vector<std::string> names;
  for (const CLI::App* verb : app_->get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

std::string Command::help() const { return app_->help(); }
bool Command::has_verb() const { return !app_->get_subcommands().empty(); }

std::optional<int> Command::parse(int argc, char** argv, int done, int bad_usage) {
  try {
    app_->parse(argc, argv);
    return {};
  } catch (const CLI::ParseError& error) {
    return app_->exit(error) == 0 ? done : bad_usage;
  }
}

}  // namespace stillframe::cli
