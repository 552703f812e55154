#include "report/plots/gnuplot.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"

namespace stillframe::report {

namespace {

std::string read_to_end(int descriptor) {
  std::string bytes;
  std::array<char, 65536> buffer;
  while (true) {
    const ssize_t n = ::read(descriptor, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return bytes;
    bytes.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

/// A file in memory only, closed when it goes out of scope.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(memfd_create(name, MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error("gnuplot: no memory for its script");
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }

  void write_all(const std::string& text) const {
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t n = ::write(descriptor_, text.data() + done, text.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) throw std::runtime_error("gnuplot: no memory for its script");
      done += static_cast<std::size_t>(n);
    }
    lseek(descriptor_, 0, SEEK_SET);
  }

  std::string read_all() const {
    lseek(descriptor_, 0, SEEK_SET);
    return read_to_end(descriptor_);
  }

 private:
  int descriptor_;
};

/// Starts gnuplot without any of the user's own settings, and answers with its exit code. What it
/// draws comes through a pipe, because it does not say when a disk is full. The script is its
/// standard input by another name: by its own it is read a byte a call, a third of the whole time.
int run_program(const MemoryFile& input, const MemoryFile& messages, std::string& picture) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("gnuplot: no pipe for its picture");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages.descriptor(), STDERR_FILENO);
  std::string name = "gnuplot", option = "-d", script = "/dev/stdin";
  std::array<char*, 4> arguments = {name.data(), option.data(), script.data(), nullptr};
  pid_t child = 0;
  const int failure = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  picture = read_to_end(ends[0]);
  close(ends[0]);
  if (failure != 0) {
    throw InputError(
        "plots: the program gnuplot cannot be started: install it with "
        "'apt-get install gnuplot-nox'");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string first_message(const std::string& output) {
  std::istringstream lines(output);
  std::string line;
  while (std::getline(lines, line)) {
    // Before the message gnuplot repeats the command, and marks the place with a caret.
    if (line.find("line ") != std::string::npos) return line.substr(line.find("line "));
  }
  return output.empty() ? "no message" : output.substr(0, 200);
}

constexpr const char* terminal =
    "set encoding utf8\n"
    "set terminal pngcairo size 1600,1000 enhanced font 'Sans,20' background rgb 'white'\n";

}  // namespace

std::string plot_number(double value) {
  if (!std::isfinite(value)) return "NaN";
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, 8)
          .ptr;
  return {text.data(), end};
}

std::string plot_text(const std::string& text) {
  std::string literal = "'";
  for (const char c : text) {
    if (c == '\'') literal += '\'';
    literal += c == '\n' ? ' ' : c;
  }
  return literal + "'";
}

std::string plot_data(const std::string& name, const Eigen::MatrixXd& rows) {
  std::string block = "$" + name + " << end_of_data\n";
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    for (Eigen::Index j = 0; j < rows.cols(); ++j) {
      if (j > 0) block += ' ';
      block += plot_number(rows(i, j));
    }
    block += '\n';
  }
  return block + "end_of_data\n";
}

void run_gnuplot(const std::string& script, const std::filesystem::path& path) {
  WholeFile file(path);
  const MemoryFile input("gnuplot_script"), messages("gnuplot_messages");
  input.write_all(terminal + script + "\nunset multiplot\nset output\n");
  std::string picture;
  const int code = run_program(input, messages, picture);
  if (code != 0 || picture.empty()) {
    throw InputError("plots: " + path.string() +
                     ": gnuplot failed: " + first_message(messages.read_all()));
  }
  file.write(picture);
  file.save();
}

}  // namespace stillframe::report
