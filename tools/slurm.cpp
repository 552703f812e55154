#include "tools/slurm.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

std::string shell_word(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string(R"('\'')") : std::string(1, c);
  return text + "'";
}

/// This process's words after the program, without those that a task has its own of.
std::string words_of_a_task() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string word, text;
  std::getline(file, word, '\0');
  while (std::getline(file, word, '\0')) {
    bool own = word == "--json";
    for (const std::string option : {"--on", "--out", "--jobs"}) {
      own = own || word.starts_with(option + "=");
      if (word != option) continue;
      own = true;
      std::getline(file, word, '\0');  // its value
      break;
    }
    if (!own) text += " " + shell_word(word);
  }
  return text;
}

/// The number of the job.
std::string submit(const std::string& options, const std::filesystem::path& script) {
  const std::string command = "sbatch --parsable " + options + " " + shell_word(script.string());
  FILE* output = popen(command.c_str(), "r");
  if (!output) throw Failure("sbatch cannot be started");
  std::array<char, 256> line{};
  const bool answered = std::fgets(line.data(), line.size(), output) != nullptr;
  const int status = pclose(output);
  if (!answered || status != 0) {
    throw Failure("sbatch did not take " + script.string() +
                  "; is this a host from which Slurm takes jobs? Its own words are above");
  }
  const std::string text = line.data(), job = text.substr(0, text.find_first_of(";\n"));
  if (job.empty() || job.find_first_not_of("0123456789") != std::string::npos) {
    throw Failure("sbatch answered '" + job +
                  "' instead of the number of a job; squeue says whether "
                  "it took " +
                  script.string());
  }
  return job;
}

}  // namespace

std::optional<std::size_t> parse_on(const std::string& text) {
  if (text.empty()) return std::nullopt;
  unsigned long long n = 0;
  int end = 0;
  const bool reads = std::sscanf(text.c_str(), "slurm:%llu%n", &n, &end) == 1 &&
                     static_cast<std::size_t>(end) == text.size() &&
                     text.find('-') == std::string::npos;
  if (!reads || n < 1 || n > 100000) {
    throw InputError("--on: found '" + text +
                     "', allowed is slurm:N with a number of tasks from 1 to 100000");
  }
  return n;
}

std::string submit_to_slurm(const std::filesystem::path& out, std::size_t n_tasks) {
  const std::string program = shell_word(std::filesystem::read_symlink("/proc/self/exe").string()),
                    words = words_of_a_task(), n = std::to_string(n_tasks);
  const std::filesystem::path script = out.string() + ".sbatch";
  write_whole_file(script,
                   "#!/bin/sh\n"
                   "# Each task of the array computes a shard; the job after it puts their rows "
                   "together.\n"
                   "out=" +
                       shell_word(out.string()) +
                       "\n"
                       "if [ -n \"$SLURM_ARRAY_TASK_ID\" ]; then\n"
                       "  part=$out.part_${SLURM_ARRAY_TASK_ID}_of_" +
                       n +
                       "\n"
                       "  # What is known need not be computed again.\n"
                       "  [ -e \"$part\" ] || [ ! -e \"$out\" ] || cp \"$out\" \"$part\"\n"
                       "  exec " +
                       program + words + " --shard \"$SLURM_ARRAY_TASK_ID/" + n +
                       "\" --out \"$part\" --jobs \"${SLURM_CPUS_PER_TASK:-1}\" > /dev/null\n"
                       "fi\n"
                       "set -e\n"
                       "set -- \"$out\".part_*_of_" +
                       n +
                       "\n"
                       "# What was known comes first: the parts begin as copies of it.\n"
                       "[ ! -e \"$out\" ] || set -- \"$out\" \"$@\"\n" +
                       program +
                       " merge \"$@\" --out \"$out.new\" > /dev/null\n"
                       "mv \"$out.new\" \"$out\"\n"
                       "rm -f \"$out\".part_*_of_" +
                       n + "\n");
  const std::string array = submit("--job-name=stillframe --array=1-" + n +
                                       " --output=" + shell_word(out.string() + ".task_%a.log"),
                                   script);
  std::string after;
  try {
    after = submit("--job-name=stillframe-merge --dependency=afterany:" + array +
                       " --output=" + shell_word(out.string() + ".log"),
                   script);
  } catch (const Failure& failure) {
    throw Failure(std::string(failure.what()) + "; the tasks are job " + array +
                  " all the same: `scancel " + array + "`, or, once they have ended, `sh " +
                  script.string() + "` puts their rows together");
  }
  return "job " + array + ": " + n + " tasks; job " + after + ": their rows, into " + out.string() +
         "\nSee squeue, and " + out.string() +
         ".*log. Then the same command without --on prints the rows; what is missing\nit computes, "
         "as the same command with --on does.\n";
}

}  // namespace stillframe::tools
