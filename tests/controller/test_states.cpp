#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "controller/supervisor.hpp"
#include "tests/controller/toy_plant.hpp"

// The table of transitions in docs/safety.md is the supervisor's: every row happens, and nothing
// else does.
namespace stillframe::controller {
namespace {

using Eigen::VectorXd;
using std::string;

/// From a state to a state, with the fault that is counted; "" is none.
struct Key {
  string from, to, fault;
  auto operator<=>(const Key&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Key& key) {
  return out << key.from << " -> " << key.to << (key.fault.empty() ? "" : ": ") << key.fault;
}

/// What a row asks of the period; "" is anything.
struct Condition {
  string asked, measurement;
};

struct Seen {
  Key key;
  Request request = Request::none;
  bool measured = false;
};

string trimmed(const string& text) {
  const size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<string> split(const string& text, char at) {
  std::vector<string> parts;
  std::istringstream stream(text);
  for (string part; std::getline(stream, part, at);) parts.push_back(trimmed(part));
  if (parts.empty()) parts.push_back("");
  return parts;
}

using Table = std::map<Key, Condition>;

Table documented() {
  std::ifstream stream(STILLFRAME_SOURCE_DIR "/docs/safety.md");
  Table table;
  bool here = false;
  for (string line; std::getline(stream, line);) {
    if (line.starts_with("#")) here = line == "### Transitions";
    if (!here || !line.starts_with("| ") || line.starts_with("| from |")) continue;
    const std::vector<string> cells = split(line.substr(1), '|');
    EXPECT_EQ(cells.size(), 6u) << line;
    if (cells.size() != 6) continue;
    for (const string& from : split(cells[0], '/')) {
      for (const string& fault : split(cells[5], '/')) {
        const bool is_new =
            table.emplace(Key{from, cells[4], fault}, Condition{cells[1], cells[2]}).second;
        EXPECT_TRUE(is_new) << "twice: " << line;
      }
    }
  }
  return table;
}

const std::map<Request, string> requests{{Request::none, ""},
                                         {Request::start, "start"},
                                         {Request::stop, "stop"},
                                         {Request::reset, "reset"}};

bool meets(const Seen& seen, const Condition& condition) {
  return (condition.asked.empty() || condition.asked == requests.at(seen.request)) &&
         (condition.measurement.empty() || condition.measurement == (seen.measured ? "yes" : "no"));
}

/// The toy's loop with every time ten times as long: the supervisor's seconds are few samples.
const Gains& slow_gains() {
  static const Gains gains = [] {
    Gains slow = toy::damped_gains();
    const Eigen::Index m = slow.n_legs();
    slow.sample_rate_hz /= 10;
    slow.leak_hz /= 10;
    slow.K_I /= 10;
    slow.plant.A.bottomLeftCorner(m, m) /= 100;
    slow.plant.A.bottomRightCorner(m, m) /= 10;
    slow.plant.C /= 100;
    return slow;
  }();
  return gains;
}

/// Only what a policy file may say. Supervisors of one policy are copies of the first, because the
/// designed loop takes long to follow.
const Supervisor& supervisor_of(const string& policy) {
  static std::map<string, Supervisor> all;
  const auto found = all.find(policy);
  if (found != all.end()) return found->second;
  const Policy parsed = policy.empty() ? Policy{} : parse_policy(policy, "policy", 1000);
  return all.emplace(policy, Supervisor(slow_gains(), parsed, true)).first->second;
}

/// What the sensors read.
enum class Sigma { moving, still, offset, large, alternating, overflowing, one_noisy };

struct Period {
  Sigma sigma = Sigma::moving;
  Defect defect = Defect::none;
  Request request = Request::none;
  std::int64_t n_elapsed = 1;
  bool heard = true;
  double follows = 1;  ///< part of the last command that the amplifiers report
  double left = 0;     ///< N, beside that
};

/// A supervisor and made-up measurements, 10 ms a period, without a frame. Amplifiers do what was
/// commanded last.
class Drive {
 public:
  explicit Drive(const string& policy, std::uint64_t seed = 1)
      : supervisor_(supervisor_of(policy)), random_(seed) {
    last_ = {{"begins", state(), ""}, Request::none, false};
    command_.force = applied_ = VectorXd::Zero(supervisor_.n_legs());
    measurement_.sigma = measurement_.applied = applied_;
    measurement_.floor = VectorXd::Zero(slow_gains().plant.B_w.cols());
  }

  void begin_latched(Fault fault) {
    supervisor_.begin_latched(fault);
    last_.key.to = state();
  }

  string state() const {
    const string text(to_text(supervisor_.state()));
    if (supervisor_.state() != State::fault) return text;
    return text + (supervisor_.latched() ? ", latched" : ", passing");
  }

  /// True if there was a transition.
  bool step(const Period& period = {}) {
    k_ += period.n_elapsed;
    measurement_.seq = k_;
    measurement_.time_ns = k_ * 10'000'000;
    measurement_.applied = period.follows * applied_;
    measurement_.applied.array() += period.left;
    measurement_.heard = period.heard;
    // Legs feel what is applied to them; the reading is what their elongation adds.
    for (double& value : measurement_.sigma) value = reading(period.sigma);
    if (period.sigma == Sigma::one_noisy) measurement_.sigma(0) *= 1e3;
    measurement_.sigma += measurement_.applied;
    const Key before{state(), "", ""};
    const std::int64_t n_faults = supervisor_.n_faults();
    const bool have = period.defect == Defect::none;
    const bool sent = supervisor_.step({.n_elapsed = period.n_elapsed,
                                        .measurement = have ? &measurement_ : nullptr,
                                        .defect = period.defect,
                                        .request = period.request},
                                       command_);
    if (sent) applied_ = command_.force;
    const std::int64_t n_new = supervisor_.n_faults() - n_faults;
    EXPECT_LE(n_new, 1);  // of two only one would be seen here
    EXPECT_TRUE(!supervisor_.latched() || supervisor_.state() == State::fault);
    if (n_new == 0 && state() == before.from) return false;
    const string fault(n_new > 0 ? to_text(supervisor_.fault()) : "");
    last_ = {{before.from, state(), fault}, period.request, have};
    return true;
  }
  void steps(int n, const Period& period = {}) {
    for (int i = 0; i < n; ++i) step(period);
  }
  /// Goes on to the next transition, which the scenario leaves to be looked at, or gives up.
  void change(const Period& period = {}) {
    for (int i = 0; i < 2000; ++i) {
      if (step(period)) return;
    }
    FAIL() << "stays " << state();
  }
  /// By the undisturbed way; fading out of active.
  void reach(const string& wanted, const Period& period = {}) {
    Period now = period;
    while (state() != wanted) {
      if (state() == "active" && wanted == "ramp_out") now.request = Request::stop;
      if (state() == "active" && wanted == "fading") now.defect = Defect::missing;
      const string from = state();
      change(now);
      now = period;
      ASSERT_NE(state(), from);
      ASSERT_TRUE(from != "active" || state() == wanted) << state();
      ASSERT_FALSE(state().starts_with("fault")) << state();
    }
  }

  const Seen& last() const { return last_; }

 private:
  double reading(Sigma sigma) {
    const double noise = 1e-3 * normal_(random_);
    switch (sigma) {
      case Sigma::moving:
      case Sigma::one_noisy:
        return noise;
      case Sigma::still:
        return 0;
      case Sigma::offset:
        return 60 + noise;  // beyond offset_limit_n, 50
      case Sigma::large:
        return 1e4;
      case Sigma::alternating:
        return k_ % 2 == 0 ? 10 : -10;
      case Sigma::overflowing:
        return 9e307;  // no screen lets it pass; the law makes infinity of it
    }
    return 0;
  }

  Supervisor supervisor_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::int64_t k_ = 0;
  Measurement measurement_;
  Command command_;
  VectorXd applied_;
  Seen last_;
};

struct Scenario {
  Key key;
  string policy;
  std::function<void(Drive&)> play;  ///< its last transition is the one
};

const string latched = "fault, latched", passing = "fault, passing";
const std::vector<string> engaged{"ramp_in", "active", "ramp_out"};
const Period missing{.defect = Defect::missing}, stop{.request = Request::stop},
    start{.request = Request::start}, still{.sigma = Sigma::still};
const std::vector<std::pair<string, Defect>> defects{{"not_finite", Defect::not_finite},
                                                     {"out_of_range", Defect::out_of_range}};
// A period as long as hold_periods, and as much of it missing.
constexpr std::int64_t longest = 11;
// A frame that stands perfectly still has no force.
const string at_rest = "arming: {require_motion: false}\n";
// Shares of missing measurements are means over 200 periods at this rate.
const string soon_losses = "measurements: {missing_part: 0.02}\n";
const string never_again = "rejoin: {a_minute: 0}\n";

void before_force(std::vector<Scenario>& all) {
  all.push_back({{"begins", "idle", ""}, "", [](Drive&) {}});
  all.push_back({{"begins", latched, ""}, "", [](Drive& d) { d.begin_latched(Fault::restless); }});
  all.push_back({{"idle", "arming", ""}, "", [](Drive& d) { d.change(); }});
  const auto from_arming = [&](const string& to, const string& fault, const Period& period) {
    all.push_back({{"arming", to, fault}, "", [period](Drive& d) {
                     d.reach("arming");
                     d.change(period);
                   }});
  };
  from_arming("idle", "", stop);
  from_arming("ramp_in", "", {});
  for (const auto& [fault, defect] : defects) from_arming(latched, fault, {.defect = defect});
  all.push_back({{"arming", latched, "not_alive"}, "", [](Drive& d) {
                   d.reach("arming", still);
                   d.change(still);
                 }});
  all.push_back({{"arming", latched, "offset"}, "", [](Drive& d) {
                   d.reach("arming", {.sigma = Sigma::offset});
                   d.change({.sigma = Sigma::offset});
                 }});
  // Half a second has too few samples to know the noise.
  all.push_back({{"arming", latched, "noisy"}, "arming: {duration_s: 1}", [](Drive& d) {
                   d.reach("arming", {.sigma = Sigma::one_noisy});
                   d.change({.sigma = Sigma::one_noisy});
                 }});
}

void ramps(std::vector<Scenario>& all) {
  all.push_back({{"ramp_in", "active", ""}, "", [](Drive& d) { d.reach("active"); }});
  for (const string from : {"ramp_in", "active"}) {
    all.push_back({{from, "ramp_out", ""}, "", [from](Drive& d) {
                     d.reach(from);
                     d.steps(5);
                     d.change(stop);
                   }});
    all.push_back({{from, "idle", ""}, "ramp: {out_s: 0.01}", [from](Drive& d) {
                     d.reach(from);
                     d.change(stop);
                   }});
  }
  const auto from_ramp_out = [&](const string& to, const string& policy, const Period& period) {
    all.push_back({{"ramp_out", to, ""}, policy, [period](Drive& d) {
                     d.reach("ramp_out");
                     d.steps(5);
                     d.change(period);
                   }});
  };
  from_ramp_out("idle", "", {});
  from_ramp_out("ramp_in", "", start);
  from_ramp_out("active", "ramp: {in_s: 0.01}", start);
}

void without_measurements(std::vector<Scenario>& all) {
  for (const string& from : engaged) {
    all.push_back({{from, "fading", ""}, "", [from](Drive& d) {
                     d.reach(from);
                     d.steps(5);
                     d.change(missing);
                   }});
    const auto nothing_to_fade = [&](const string& to, const string& fault, Defect defect) {
      all.push_back({{from, to, fault}, at_rest, [from, defect](Drive& d) {
                       d.reach(from, still);
                       d.change({.defect = defect});
                     }});
    };
    nothing_to_fade(passing, "silence", Defect::missing);
    for (const auto& [fault, defect] : defects) nothing_to_fade(latched, fault, defect);
  }
}

void out_of_a_fade(std::vector<Scenario>& all) {
  const auto from_fading = [&](const string& to, const string& fault, const string& policy,
                               const Period& period, Request asked = Request::none) {
    all.push_back({{"fading", to, fault}, policy, [period, asked](Drive& d) {
                     d.reach("fading");
                     d.step({.defect = Defect::missing, .request = asked});
                     d.change(period);
                   }});
  };
  from_fading("ramp_in", "", "", {});
  from_fading("active", "", "ramp: {in_s: 0.01}", {});
  from_fading("ramp_out", "", "", {}, Request::stop);
  from_fading("idle", "", "ramp: {out_s: 0.01}", {}, Request::stop);
  from_fading(passing, "silence", "", missing);
  for (const auto& [fault, defect] : defects) from_fading(latched, fault, "", {.defect = defect});

  // Measurements that come too late to go on with, before the fade of 2 s ends.
  const string slow_fade = "measurements: {fade_s: 2}\n";
  const auto late = [&](const string& to, const string& policy, Request asked) {
    all.push_back({{"fading", to, "silence"}, slow_fade + policy, [asked](Drive& d) {
                     d.reach("fading");
                     d.step({.defect = Defect::missing, .request = asked});
                     d.steps(110, missing);
                     d.change();
                   }});
  };
  late("arming", "", Request::none);
  late("idle", "", Request::stop);
  late(latched, never_again, Request::none);

  // A long period, half of it past the end of the fade, is one loss too many.
  const string short_fade = "measurements: {fade_s: 0.1, missing_part: 0.1}\n";
  const auto lost = [&](const string& to, const string& policy, Request asked) {
    all.push_back({{"fading", to, "losses"}, short_fade + policy, [asked](Drive& d) {
                     d.reach("fading");
                     d.step({.defect = Defect::missing, .request = asked});
                     d.steps(7, missing);
                     d.change({.n_elapsed = longest});
                   }});
  };
  lost("arming", "", Request::none);
  lost("idle", "", Request::stop);
  lost(latched, never_again, Request::none);
}

void faults_of_the_loop(std::vector<Scenario>& all) {
  // Infinite pace, so that nothing but the limit is met; and the reverse.
  const string low_limit =
      "limits: {force_n: 10, free_rate_n_per_s: 1.0e+12}\nwatch: {limited_part: 0.01}\n";
  const string slow_pace = "limits: {free_rate_n_per_s: 0.001}\narming: {duration_s: 1}\n";
  const auto from_engaged = [&](const string& from, const string& to, const string& fault,
                                const string& policy, const Period& period) {
    all.push_back({{from, to, fault}, policy, [from, period](Drive& d) {
                     d.reach(from);
                     if (from != "fading") d.steps(20);
                     d.change(period);
                   }});
  };
  const Period overflowing{.sigma = Sigma::overflowing};
  for (const string& from : engaged) {
    from_engaged(from, latched, "limited", low_limit, {.sigma = Sigma::large});
    from_engaged(from, latched, "restless", slow_pace, {.sigma = Sigma::alternating});
    from_engaged(from, latched, "disobeyed", "", {.left = 20});
    from_engaged(from, passing, "losses", soon_losses, {.n_elapsed = longest});
    from_engaged(from, passing, "unheard", "ramp: {in_s: 2, out_s: 2}", {.heard = false});
  }
  from_engaged("fading", passing, "losses", "measurements: {missing_part: 0.07}", missing);
  for (const string from : {"ramp_in", "active", "ramp_out", "fading"}) {
    from_engaged(from, latched, "law_not_finite", "", overflowing);
    from_engaged(from, passing, "suspended", "", {.n_elapsed = longest + 1});
  }

  const auto no_force = [&](const string& from, const string& to, const string& policy,
                            Request asked) {
    all.push_back({{from, to, "losses"}, at_rest + soon_losses + policy, [from, asked](Drive& d) {
                     d.reach(from, still);
                     d.change({.request = asked, .n_elapsed = longest});
                   }});
  };
  for (const string from : {"ramp_in", "active"}) {
    no_force(from, "arming", "", Request::none);
    no_force(from, "idle", "", Request::stop);
    no_force(from, latched, never_again, Request::none);
  }
  no_force("ramp_out", "idle", "", Request::none);
  no_force("ramp_out", "arming", "", Request::start);
  no_force("ramp_out", latched, never_again, Request::start);
}

void out_of_faults(std::vector<Scenario>& all) {
  const auto after_a_sleep = [&](const string& to, const string& policy, Request asked) {
    all.push_back({{passing, to, ""}, policy, [asked](Drive& d) {
                     d.reach("active");
                     d.change({.n_elapsed = longest + 1});
                     d.step({.request = asked});
                     d.change();
                   }});
  };
  after_a_sleep("arming", "", Request::none);
  after_a_sleep("idle", "", Request::stop);
  after_a_sleep(latched, never_again, Request::none);
  all.push_back({{latched, "idle", ""}, "", [](Drive& d) {
                   d.begin_latched(Fault::offset);
                   d.change({.request = Request::reset});
                 }});
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> all;
  before_force(all);
  ramps(all);
  without_measurements(all);
  out_of_a_fade(all);
  faults_of_the_loop(all);
  out_of_faults(all);
  return all;
}

TEST(States, EveryDocumentedTransitionHappens) {
  const Table table = documented();
  std::set<Key> played;
  for (const Scenario& scenario : scenarios()) {
    SCOPED_TRACE(testing::Message() << scenario.key);
    EXPECT_TRUE(played.insert(scenario.key).second) << "two scenarios";
    Drive drive(scenario.policy);
    scenario.play(drive);
    EXPECT_EQ(drive.last().key, scenario.key) << "seen: " << drive.last().key;
    const auto row = table.find(scenario.key);
    if (row == table.end()) {
      ADD_FAILURE() << "not in docs/safety.md";
    } else {
      EXPECT_TRUE(meets(drive.last(), row->second)) << "asked or measurement is not the table's";
    }
  }
  for (const auto& [key, condition] : table) {
    EXPECT_TRUE(played.contains(key)) << "no scenario makes " << key;
  }
}

/// Stretches of one kind of trouble or of none, which is the most frequent: else nothing is ever
/// reached.
class RandomWorld {
 public:
  explicit RandomWorld(std::uint64_t seed) : random_(seed), at_rest_(random_() % 3 == 0) {}

  Period next() {
    if (--left_ < 0) turn();
    Period period = kind_;
    if (flaky_ && one_in(2)) period.defect = Defect::missing;
    if (sleepy_)
      period.n_elapsed = 1 + static_cast<std::int64_t>(random_() % (one_in(20) ? 13 : 11));
    if (one_in(60)) period.request = static_cast<Request>(random_() % 4);
    if (one_in(100)) period.n_elapsed += static_cast<std::int64_t>(random_() % 14);
    if (one_in(500)) period.follows = 0;  // an amplifier has let go by itself
    return period;
  }

 private:
  bool one_in(std::uint64_t n) { return random_() % n == 0; }

  void turn() {
    const std::uint64_t what = random_() % 21;
    kind_ = {.sigma = at_rest_ ? Sigma::still : Sigma::moving};
    flaky_ = sleepy_ = false;
    left_ = static_cast<int>(random_() % 150);
    if (what == 0) kind_.sigma = static_cast<Sigma>(random_() % 7);
    if (what == 1 || what == 2) kind_.defect = Defect::missing;
    if (what == 3) kind_.defect = Defect::not_finite;
    if (what == 4) kind_.defect = Defect::out_of_range;
    if (what == 5) flaky_ = true;
    if (what == 6) sleepy_ = true;
    if (what == 7) flaky_ = sleepy_ = true;
    if (what == 8) kind_.heard = false;
    if (what == 9) {
      kind_.left = 1e4;
      sleepy_ = one_in(2);
      left_ += 150;  // seconds of long periods
    }
    // Gaps that end while the loop still fades are the most eventful.
    if (what >= 1 && what <= 7 && one_in(2)) left_ = 5 + static_cast<int>(random_() % 20);
  }

  std::mt19937_64 random_;
  bool at_rest_;
  Period kind_;
  bool flaky_ = false, sleepy_ = false;
  int left_ = 0;
};

TEST(States, NoRandomHistoryHasAnotherTransition) {
  const string quick = "arming: {duration_s: 0.2, require_motion: false}\n";
  const std::vector<string> policies{
      "",
      "arming: {duration_s: 1}\nlimits: {free_rate_n_per_s: 0.001}\n",
      quick,
      quick + "measurements: {fade_s: 0.1, missing_part: 0.1}\nramp: {in_s: 0.2, out_s: 0.2}\n",
      quick + "measurements: {fade_s: 0.1, missing_part: 0.1}\n" + never_again,
      quick + "measurements: {fade_s: 2, hold_periods: 3}\nramp: {in_s: 0.01, out_s: 0.01}\n",
      quick + "measurements: {fade_s: 2}\nrejoin: {a_minute: 1}\n",
      quick + "measurements: {fade_s: 0.1, hold_periods: 20}\nramp: {in_s: 0.1, out_s: 0.5}\n",
      quick + "measurements: {hold_periods: 0}\nramp: {in_s: 0.5, out_s: 0.1}\n",
      quick + soon_losses,
      quick + soon_losses + never_again,
      quick + "limits: {force_n: 10, free_rate_n_per_s: 1.0e+12}\nwatch: {limited_part: 0.01}\n",
      quick + "start: on_request\nmeasurements: {fade_s: 0.5, missing_part: 0.07}\n"};
  const Table table = documented();
  std::map<Key, int> seen;
  constexpr int n_sequences = 12'000, n_periods = 500;
  for (int i = 0; i < n_sequences; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    Drive drive(policies[static_cast<size_t>(i) % policies.size()], seed);
    RandomWorld world(seed + n_sequences);
    for (int k = 0; k < n_periods; ++k) {
      if (!drive.step(world.next())) continue;
      const Seen& now = drive.last();
      const auto row = table.find(now.key);
      ASSERT_NE(row, table.end()) << "not in docs/safety.md: " << now.key << ", sequence " << i;
      ASSERT_TRUE(meets(now, row->second))
          << now.key << ", sequence " << i << ", asked '" << requests.at(now.request)
          << "', measurement " << now.measured;
      ++seen[now.key];
    }
  }
  std::ostringstream not_met;
  size_t n_not_met = 0;
  for (const auto& [key, condition] : table) {
    if (seen.contains(key) || key.from == "begins") continue;
    ++n_not_met;
    not_met << "\n  " << key;
  }
  std::cout << "reached " << seen.size() << " transitions, not these " << n_not_met << ":"
            << not_met.str() << std::endl;
  // A walk that goes nowhere would agree with any table. Of 75 these seeds reach 71; the others
  // need a request or a loss in one certain period.
  EXPECT_GE(seen.size(), 60u);
}

}  // namespace
}  // namespace stillframe::controller
