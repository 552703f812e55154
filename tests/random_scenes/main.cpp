#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "core/cli/command.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/modes.hpp"
#include "tests/random_scenes/generator/draft.hpp"
#include "tests/random_scenes/relation.hpp"
#include "tests/random_scenes/shrink.hpp"

namespace stillframe::random_scenes {
namespace {

struct Options {
  int n = 0;
  std::uint64_t seed = 1;
  int first = 0, jobs = 1;
  std::vector<std::string> only;
  std::filesystem::path failed = "failed_scenes", scene;
  bool print = false, times = false;
};

/// Scene `number` of a seed.
std::uint64_t scene_seed(std::uint64_t seed, int number) {
  return seed * 1'000'000 + static_cast<std::uint64_t>(number);
}

/// One relation on one scene. An exception is a violation: the scene itself was accepted.
std::optional<Finding> check(const Relation& relation, Case& scene, std::uint64_t seed) {
  try {
    return relation.check(scene, seed);
  } catch (const std::exception& error) {
    Finding finding;
    finding.take(1, 0, error.what());
    return finding;
  }
}

/// Why a scene is refused as it stands (no equilibrium, not stable), if it is: then nothing is
/// asked of it. Errors: InputError, which no scene of the generator may cause.
std::string refusal(Case& scene) {
  try {
    modes(scene.linear());
    if (scene.has_loop()) scene.design();
  } catch (const Refusal& refusal) {
    return refusal.what();
  }
  return "";
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What is known of one relation after some scenes.
struct Tally {
  int applied = 0, violations = 0;
  std::int64_t compared = 0, unknown = 0;  ///< numbers, as in Finding
  double seconds = 0, longest = 0;         ///< of all scenes, and of one
  std::map<std::string, int> skipped;      ///< what was too dear to compare, and on how many scenes
  std::vector<double> shares;              ///< of the bound that each scene used up
  Finding worst;
  std::uint64_t worst_seed = 0, longest_seed = 0;
};

class Run {
 public:
  explicit Run(const Options& options) : options_(options) {
    for (const Relation& relation : relations()) {
      if (options.only.empty() ||
          std::count(options.only.begin(), options.only.end(), relation.name)) {
        relations_.push_back(&relation);
      }
    }
    tallies_.resize(relations_.size());
  }

  int run() {
    std::vector<std::thread> threads;
    for (int i = 1; i < options_.jobs; ++i) threads.emplace_back([this] { work(); });
    work();
    for (std::thread& thread : threads) thread.join();
    print_table();
    const bool looked = has_looked();
    return n_violations() > 0 || !looked ? 4 : 0;
  }

 private:
  void work() {
    for (int i = next_++; i < options_.n; i = next_++) {
      const std::uint64_t seed = scene_seed(options_.seed, options_.first + i);
      one(random_scene(seed), seed);
    }
  }

  void one(const std::string& text, std::uint64_t seed) {
    const auto begin = std::chrono::steady_clock::now();
    std::optional<Case> scene;
    std::string refused;
    try {
      scene.emplace(text);
      refused = refusal(*scene);
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      ++illegal_;
      std::cout << "scene " << seed << " is not legal: " << error.what() << std::endl;
      return;
    }
    if (!refused.empty()) {
      const std::lock_guard lock(mutex_);
      // Without the numbers and names of the scene.
      ++refused_[refused.substr(
          0, std::min(refused.find_first_of("0123456789:"), refused.find(" of leg_")))];
      return;
    }
    std::ostringstream times;
    for (size_t i = 0; i < relations_.size(); ++i) {
      const auto start = std::chrono::steady_clock::now();
      const auto finding = check(*relations_[i], *scene, seed);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      note(i, finding, took.count(), seed);
      times << ' ' << relations_[i]->name << ' ' << took.count();
      for (const std::string& what : finding ? finding->skipped : std::vector<std::string>{}) {
        times << " (without " << what << ")";
      }
      if (finding && !finding->holds()) report(*relations_[i], text, seed, *finding);
    }
    const std::chrono::duration<double> all = std::chrono::steady_clock::now() - begin;
    const std::lock_guard lock(mutex_);
    if (all.count() > slowest_) slowest_ = all.count(), slowest_seed_ = seed;
    if (options_.times) {
      std::cerr << "scene " << seed << ", s:" << times.str() << std::endl;
    }
    if (++n_done_ % 100 == 0) {
      const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begin_;
      std::cerr << n_done_ << " of " << options_.n << " scenes, " << n_violations()
                << " violations, " << std::lround(since.count()) << " s" << std::endl;
    }
  }

  void note(size_t i, const std::optional<Finding>& finding, double seconds, std::uint64_t seed) {
    const std::lock_guard lock(mutex_);
    Tally& tally = tallies_[i];
    tally.seconds += seconds;
    if (seconds > tally.longest) tally.longest = seconds, tally.longest_seed = seed;
    if (!finding) return;
    for (const std::string& what : finding->skipped) ++tally.skipped[what];
    if (finding->compared == 0 && !finding->skipped.empty()) return;
    ++tally.applied;
    tally.compared += finding->compared;
    tally.unknown += finding->unknown;
    if (!finding->holds()) ++tally.violations;
    tally.shares.push_back(finding->share());
    if (tally.applied == 1 || finding->share() > tally.worst.share()) {
      tally.worst = *finding;
      tally.worst_seed = seed;
    }
  }

  /// Shrinks a scene that fails and writes it.
  void report(const Relation& relation, const std::string& text, std::uint64_t seed,
              const Finding& finding) {
    std::ostringstream what;
    what << relation.name << ": scene " << seed << ": " << finding.what << ": " << finding.value
         << " for at most " << finding.bound;
    {
      const std::lock_guard lock(mutex_);
      std::cout << what.str() << std::endl;
    }
    const std::string small = shrink(text, [&](const std::string& trial) {
      try {
        Case scene(trial);
        if (!refusal(scene).empty()) return false;
        const auto found = check(relation, scene, seed);
        // The same way: an exception stays the same one.
        return found && !found->holds() && (found->bound > 0) == (finding.bound > 0) &&
               (found->bound > 0 || found->what.substr(0, 30) == finding.what.substr(0, 30));
      } catch (const std::exception&) {
        return false;
      }
    });
    std::filesystem::create_directories(options_.failed);
    const auto place = options_.failed / (std::to_string(seed) + "_" + relation.name + ".yaml");
    std::ofstream(place) << "# " << what.str() << "\n# seed: " << seed << "\n" << small;
    const std::lock_guard lock(mutex_);
    std::cout << "  written to " << place.string() << std::endl;
  }

  int n_violations() const {
    int n = illegal_;
    for (const Tally& tally : tallies_) n += tally.violations;
    return n;
  }

  int n_refused() const {
    int n = 0;
    for (const auto& [why, of_it] : refused_) n += of_it;
    return n;
  }

  /// A run that asks nothing of its scenes has no violation either. Says what is wrong. One in
  /// seven is refused; the rarest domain is a quarter of the rest, and none of it among as many as
  /// enough_ one in a million.
  bool has_looked() const {
    const int refused = n_refused(), accepted = options_.n - refused - illegal_;
    bool good = true;
    if (accepted == 0 || (options_.n >= enough_ && 3 * refused > options_.n)) {
      std::printf("%d of %d scenes are refused: more than a third is too many.\n", refused,
                  options_.n);
      good = false;
    }
    for (size_t i = 0; i < relations_.size(); ++i) {
      if (accepted < enough_ || tallies_[i].applied > 0) continue;
      std::printf("%s applied to none of %d scenes.\n", relations_[i]->name, accepted);
      good = false;
    }
    return good;
  }

  void print_table() const {
    std::printf(
        "%d scenes of seed %llu, %d refused as they stand, %d not legal; slowest: scene %llu, %.2f "
        "s\n",
        options_.n, static_cast<unsigned long long>(options_.seed), n_refused(), illegal_,
        static_cast<unsigned long long>(slowest_seed_), slowest_);
    for (const auto& [why, n] : refused_) std::printf("  %d: %s...\n", n, why.c_str());
    std::printf("\n%-14s %8s %10s %9s %9s %8s %10s %10s %8s %9s %9s  %s\n", "relation", "scenes",
                "violations", "numbers", "not known", "skipped", "worst", "bound", "median",
                "ms/scene", "longest", "where");
    for (size_t i = 0; i < relations_.size(); ++i) {
      const Tally& t = tallies_[i];
      int skipped = 0;
      for (const auto& [what, n] : t.skipped) skipped += n;
      std::printf(
          "%-14s %8d %10d %9lld %9lld %8d %10.2e %10.2e %8.1e %9.1f %7.1f s  %s, scene %llu; "
          "longest: %llu\n",
          relations_[i]->name, t.applied, t.violations, static_cast<long long>(t.compared),
          static_cast<long long>(t.unknown), skipped, t.worst.value, t.worst.bound,
          median(t.shares), 1e3 * t.seconds / std::max(1, options_.n), t.longest,
          t.worst.what.c_str(), static_cast<unsigned long long>(t.worst_seed),
          static_cast<unsigned long long>(t.longest_seed));
    }
    for (size_t i = 0; i < relations_.size(); ++i) {
      for (const auto& [what, n] : tallies_[i].skipped) {
        std::printf("%s on %d scenes without %s, which would take too long\n", relations_[i]->name,
                    n, what.c_str());
      }
    }
  }

  static constexpr int enough_ = 50;
  const Options& options_;
  std::vector<const Relation*> relations_;
  std::vector<Tally> tallies_;
  std::map<std::string, int> refused_;
  int illegal_ = 0, n_done_ = 0;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double slowest_ = 0;
  std::uint64_t slowest_seed_ = 0;
  std::atomic<int> next_ = 0;
  mutable std::mutex mutex_;
};

/// All relations on a scene of a file, whose head may state the seed.
int check_file(const Options& options) {
  std::ostringstream text;
  text << std::ifstream(options.scene).rdbuf();
  std::uint64_t seed = options.seed;
  const std::string head = "# seed: ";
  const size_t stated = text.str().find(head);
  if (stated != std::string::npos) seed = std::stoull(text.str().substr(stated + head.size()));
  Case scene(text.str(), options.scene.string());
  scene.in_full = true;
  if (const std::string why = refusal(scene); !why.empty()) {
    std::cout << "refused: " << why << "\n";
    return 3;
  }
  int code = 0;
  for (const Relation& relation : relations()) {
    if (!options.only.empty() &&
        !std::count(options.only.begin(), options.only.end(), relation.name))
      continue;
    const auto found = check(relation, scene, seed);
    if (!found) {
      std::printf("%-14s not in its domain\n", relation.name);
      continue;
    }
    if (!found->holds()) code = 4;
    for (const std::string& what : found->skipped) {
      std::printf("%-14s without %s, which would take too long\n", relation.name, what.c_str());
    }
    if (found->compared == 0 && !found->skipped.empty()) continue;
    std::printf("%-14s %s: %g for at most %g: %s\n", relation.name,
                found->holds() ? "holds" : "VIOLATED", found->value, found->bound,
                found->what.c_str());
  }
  return code;
}

int run(int argc, char** argv) {
  cli::Command app("Random scenes: relations that must hold on every one");
  Options options;
  app.option("n", options.n, "How many scenes");
  app.option("seed", options.seed, "Of all of them; another seed is another set").show_default();
  app.option("--first", options.first, "Number of the first one").show_default();
  app.option("--jobs", options.jobs, "Scenes at a time")
      .check(cli::whole_number(1, 1024))
      .show_default();
  auto only = app.option("--relation", options.only, "This relation alone; may be given again");
  app.option("--failed", options.failed, "Folder for the shrunk scenes that fail").show_default();
  app.option("--scene", options.scene, "Check this scene file instead");
  app.flag("--print", options.print, "Print the scenes instead");
  app.flag("--times", options.times,
           "A line a scene on stderr: what each relation took (s), and what it left out");
  std::string names;
  std::vector<std::string> known;
  for (const Relation& relation : relations()) {
    names += std::string("  ") + relation.name + ": " + relation.bound + "\n";
    known.push_back(relation.name);
  }
  app.footer("Relations, with what bounds them:\n" + names +
             "Exit code 4: a relation is violated, or hardly any scene was looked at.");
  only.check(cli::one_of(known));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (!options.scene.empty()) return check_file(options);
  if (options.n < 1) throw std::invalid_argument("how many scenes? (--help)");
  if (options.print) {
    for (int i = 0; i < options.n; ++i)
      std::cout << random_scene(scene_seed(options.seed, options.first + i)) << "\n";
    return 0;
  }
  return Run(options).run();
}

}  // namespace
}  // namespace stillframe::random_scenes

int main(int argc, char** argv) {
  try {
    return stillframe::random_scenes::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "random_scenes: " << error.what() << "\n";
    return 2;
  }
}
