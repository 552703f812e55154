#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

// The command line of a program. CLI11 stands behind command.cpp alone, because every file that
// includes it compiles twice as long.
namespace stillframe::cli {

/// What the text of an option has to be.
class Check {
 public:
  explicit Check(std::shared_ptr<CLI::Validator> validator) : validator_(std::move(validator)) {}
  const CLI::Validator& validator() const { return *validator_; }

 private:
  std::shared_ptr<CLI::Validator> validator_;
};

/// Finite numbers: CLI11's own checks let NaN and infinity pass.
Check positive_number();
Check number_from_zero();
/// Both ends are allowed.
Check whole_number(std::int64_t lowest, std::int64_t highest);
Check number_between(double lowest, double highest);
Check one_of(std::vector<std::string> words);
Check existing_file();
Check existing_folder();

/// An option of a command, as long as the command lives.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required();
  /// What the help calls its value.
  Option type_name(const std::string& name);
  Option check(const Check& check);
  /// The help says what it is without.
  Option show_default();
  Option default_text(const std::string& text);
  Option delimiter(char between);
  /// Of an option that may be given again: takes one text each time, so that a positional one may
  /// follow.
  Option one_each_time();
  /// The value may be left out.
  Option optional_value();
  Option excludes(Option other);

 private:
  CLI::Option* option_;
};

/// A program, or one of its verbs.
class Command {
 public:
  /// Of a program. Its options and verbs are added to it; it outlives them.
  explicit Command(const std::string& description, const std::string& name = "");

  Command verb(const std::string& name, const std::string& description);
  void footer(const std::string& text);
  void version(const std::string& text);
  void at_most_one_verb();
  /// The help lists the verbs that are added from now on under this title.
  void next_group(const std::string& title) { group_ = title; }
  /// What is done once the whole command line has been read.
  void runs(std::function<void()> action);

  Option flag(const std::string& name, bool& value, const std::string& help);
  /// Defined for double, int, std::int64_t, std::uint64_t, std::string and paths, all of them
  /// optional as well, and for several texts or paths.
  template <class Value>
  Option option(const std::string& name, Value& value, const std::string& help);

  std::vector<std::string> verbs() const;
  std::string help() const;
  /// Reads a command line and does what was asked for; nothing where it says so itself, as at
  /// --help. Nothing is returned where it was read, else the exit code: done or bad usage.
  std::optional<int> parse(int argc, char** argv, int done = 0, int bad_usage = 2);
  bool has_verb() const;

 private:
  explicit Command(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}

  std::shared_ptr<CLI::App> app_;
  std::string group_;
};

}  // namespace stillframe::cli
