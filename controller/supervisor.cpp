#include "controller/supervisor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "controller/slow_loops.hpp"
#include "controller/start_check.hpp"
#include "core/numerics/smooth_step.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// At first the loop listens so long before it commands: another controller may serve the run.
constexpr double quiet_s = 0.35;
// Amplifiers that hear nothing let go of a force within about a second. It is theirs until then:
// what acts is known from a read-back alone, which may lie. What they hold lasts longer in a slow
// loop.
constexpr double let_go_s = 1.5;
constexpr double missing_s = 1;  // over which the share of missing measurements is a mean
// Where the policy does not say what may push a frame beside its floor: a tenth of the force limit
// in a second, as a person or a stage does, but no more than a floor asks for that is too quiet to
// be measured. A limit that stands for none is no permission to do anything.
constexpr double free_part = 0.1, free_floor = 1e-4;
// Of a fade from other than the last command: what is left of the step after a sample.
constexpr double step_kept = 0.7;

Pace::Settings pace_settings(const Gains& gains, const Policy& policy) {
  Pace::Settings settings{.ramp_in_s = policy.ramp_in_s,
                          .ramp_out_s = policy.ramp_out_s,
                          .force_limit = force_limit(gains, policy),
                          .excited = policy.excitation.kind != ExcitationPlan::Kind::none};
  if (!policy.free_rate_n_per_s) settings.beside = free_floor;
  const double free_rate =
      free_part * settings.force_limit / slowed(1, gains.sample_rate_hz);  // N/s
  settings.free = policy.free_rate_n_per_s.value_or(free_rate) * gains.sample_time();
  return settings;
}

std::int64_t let_go_samples(double sample_time) {
  const double held = static_cast<double>(amplifiers_hold);
  return std::llround(std::max(let_go_s / sample_time, held + amplifiers_fade_s / sample_time));
}

template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Writes values one after the other as doubles, or reads them back. Whole numbers stay below
/// 2^53.
class Writer {
 public:
  explicit Writer(std::span<double> memory) : memory_(memory) {}
  template <Scalar T>
  void operator()(T& value) noexcept {
    memory_[i_++] = static_cast<double>(value);
  }
  template <class Derived>
  void operator()(Eigen::PlainObjectBase<Derived>& values) noexcept {
    for (Index j = 0; j < values.size(); ++j) memory_[i_++] = values.data()[j];
  }

 private:
  std::span<double> memory_;
  std::size_t i_ = 0;
};

class Reader {
 public:
  explicit Reader(std::span<const double> memory) : memory_(memory) {}
  template <Scalar T>
  void operator()(T& value) noexcept {
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(static_cast<std::int64_t>(memory_[i_++]));
    } else {
      value = static_cast<T>(memory_[i_++]);
    }
  }
  template <class Derived>
  void operator()(Eigen::PlainObjectBase<Derived>& values) noexcept {
    for (Index j = 0; j < values.size(); ++j) values.data()[j] = memory_[i_++];
  }

 private:
  std::span<const double> memory_;
  std::size_t i_ = 0;
};

class Counter {
 public:
  template <Scalar T>
  void operator()(T&) noexcept {
    ++n;
  }
  template <class Derived>
  void operator()(Eigen::PlainObjectBase<Derived>& values) noexcept {
    n += static_cast<std::size_t>(values.size());
  }
  std::size_t n = 0;
};

Fault fault_of(Defect defect) noexcept {
  switch (defect) {
    case Defect::not_finite:
      return Fault::not_finite;
    case Defect::out_of_range:
      return Fault::out_of_range;
    default:
      return Fault::silence;
  }
}

}  // namespace

std::string_view to_text(State state) noexcept {
  constexpr std::array<std::string_view, 7> names{"idle",   "arming",   "ramp_in", "active",
                                                  "fading", "ramp_out", "fault"};
  const auto i = static_cast<std::size_t>(state);
  return i < names.size() ? names[i] : "";
}

Supervisor::Supervisor(const Gains& gains, const Policy& policy, bool active)
    : law_(law_from_gains(gains)),
      policy_(policy),
      limits_(force_limit(gains, policy), policy, gains.n_legs(), gains.sample_time()),
      arming_(gains.n_legs(), policy, gains.sample_rate_hz),
      watch_(gains.n_legs(), gains.sample_time(), force_limit(gains, policy), policy.limited_part),
      obedience_(gains, policy.disobeyed_part),
      pace_(gains, pace_settings(gains, policy)),
      floor_evidence_(gains),
      floor_watch_(law_.floor().n_floor(), policy, gains.sample_time()),
      excitation_(gains, policy),
      sample_time_(gains.sample_time()),
      forgets_(sample_time_ / slowed(missing_s, gains.sample_rate_hz)),
      let_go_(let_go_samples(sample_time_)),
      active_(active),
      wanted_(active && policy.start_at_once),
      quiet_(let_go_) {
  ramp_ = allowed_ = excited_ = excited_before_ = change_ = asked_ = asked_before_ = base_ = step_ =
      force_ = u_ = offset_ = sigma_ = VectorXd::Zero(law_.n_legs());
  Counter counter;
  visit(counter);
  memory_size_ = counter.n;
}

template <class Archive>
void Supervisor::visit(Archive& archive) {
  archive(state_), archive(fault_), archive(latched_), archive(wanted_), archive(met_);
  archive(law_ran_), archive(missing_), archive(unheard_), archive(missing_part_);
  archive(last_defect_);
  archive(quiet_), archive(held_);
  archive(rejoins_), archive(passing_fault_), archive(p_), archive(q_);
  archive(base_), archive(step_), archive(force_), archive(offset_);
  archive(asked_before_), archive(excited_before_), archive(met_limit_);
  archive(seq_), archive(law_seq_), archive(floor_seq_), archive(time_ns_);
  archive(n_faults_), archive(n_rejoins_), archive(n_saturated_);
  law_.visit(archive);
  limits_.visit(archive);
  arming_.visit(archive);
  watch_.visit(archive);
  obedience_.visit(archive);
  pace_.visit(archive);
  floor_evidence_.visit(archive);
  floor_watch_.visit(archive);
  excitation_.visit(archive);
}

void Supervisor::save(std::span<double> memory) const noexcept {
  Writer writer(memory);
  // The writer changes nothing; one list of the members serves both ways.
  const_cast<Supervisor*>(this)->visit(writer);
}

void Supervisor::restore(std::span<const double> memory) noexcept {
  Reader reader(memory);
  visit(reader);
}

bool Supervisor::engaged() const noexcept {
  return state_ == State::ramp_in || state_ == State::active || state_ == State::ramp_out;
}

bool Supervisor::step(const Event& event, Command& command) noexcept {
  pace_.forget(event.n_elapsed);
  excited_.setZero();
  if (event.measurement != nullptr) {
    seq_ = event.measurement->seq;
    hear_floor(event);
    time_ns_ = static_cast<double>(event.measurement->time_ns);
    if (!met_) fall_silent(0);
    met_ = true;
  } else {
    seq_ += event.n_elapsed;
    time_ns_ += static_cast<double>(event.n_elapsed) * sample_time_ * 1e9;
  }
  take(event.request);
  count_missing(event);
  if (event.n_elapsed - 1 > policy_.hold_periods) fall_silent(event.n_elapsed);
  watch(event);

  bool send = event.measurement != nullptr;
  if (engaged()) {
    if (send) run_law(event);
  } else {
    if (event.measurement != nullptr && unheard_ > 0 && q_ > 0) fall_silent(0);
    const double before = q_;
    q_ = std::max(0.0, q_ - static_cast<double>(event.n_elapsed) * sample_time_ / policy_.fade_s);
    step_ *= step_kept;
    force_ = (base_ + step_) * smooth_step(q_);
    send |= before > 0 && met_;
    if (state_ == State::fading && q_ == 0) let_go(fault_of(last_defect_), event);
    if (state_ == State::fault) come_back(event);
    if (state_ == State::idle && wanted_ && q_ == 0 && event.measurement) {
      state_ = State::arming;
      restart_arming();
    } else if (state_ == State::arming) {
      arm(event);
    }
  }
  if (quiet_ > 0) {
    listen(event);
    send = false;
  }
  command.seq = seq_;
  command.time_ns = static_cast<std::int64_t>(time_ns_);
  Limits::Passed passed;
  if (send) {
    Index hurries = -1;
    if (engaged()) {
      // What an actuator would not do the law goes on asking for; its own change is judged then.
      const VectorXd& before = met_limit_ ? asked_before_ : limits_.last();
      change_ = asked_ - before - ramp_;
      allowed_ = pace_.most(n_samples_) + ramp_.cwiseAbs();
      hurries = pace_.command(n_samples_, change_);
      asked_before_ = asked_;
      passed = limits_.pass(force_, allowed_);
      met_limit_ = passed.by_actuator || (met_limit_ && passed.limited);
      if (passed.by_actuator) pace_.lose_track();
    } else {
      passed = limits_.pass(force_);
    }
    n_saturated_ += passed.limited ? 1 : 0;
    watch_.command(force_, engaged(), hurries);
    obedience_.command(force_);
  }
  command.saturated = passed.limited;
  command.force = force_;
  return send;
}

void Supervisor::take(Request request) noexcept {
  switch (request) {
    case Request::none:
      return;
    case Request::start:
      if (latched_ || !active_) return;
      wanted_ = true;
      if (state_ == State::ramp_out) state_ = State::ramp_in;
      return;
    case Request::stop:
      wanted_ = false;
      if (state_ == State::arming) state_ = State::idle;
      if (state_ == State::ramp_in || state_ == State::active) {
        state_ = State::ramp_out;
        pace_.let_go(limits_.last());
      }
      return;
    case Request::reset:
      if (!latched_) return;
      latched_ = false;
      state_ = State::idle;
      return;
  }
}

void Supervisor::count_missing(const Event& event) noexcept {
  const auto n = static_cast<double>(event.n_elapsed);
  const bool have = event.measurement != nullptr;
  // While nothing is held nothing can be lost: each arming begins with a clean sheet.
  const double share = have ? (n - 1) / n : 1.0;
  missing_part_ += std::min(1.0, n * forgets_) * (share - missing_part_);
  rejoins_ = std::max(
      0.0, rejoins_ - n * sample_time_ / 60 * static_cast<double>(policy_.rejoins_a_minute));
  if (have) {
    gap_ = missing_;
    unheard_ = event.measurement->heard ? 0 : unheard_ + gap_ + event.n_elapsed;
    missing_ = 0;
    last_defect_ = Defect::none;
    return;
  }
  missing_ += event.n_elapsed;
  // What is broken is not mended by what comes late or not at all: only by a sound measurement.
  if (is_passing(fault_of(last_defect_))) last_defect_ = event.defect;
}

void Supervisor::watch(const Event& event) noexcept {
  if (engaged() && unheard_ > Law::longest_gap) return let_go(Fault::unheard, event);
  if (engaged() && watch_.limited()) return let_go(Fault::limited, event);
  if (engaged() && watch_.restless()) return let_go(Fault::restless, event);
  if (engaged() || state_ == State::fading) {
    if (event.n_elapsed - 1 > policy_.hold_periods) return let_go(Fault::suspended, event);
    if (engaged() && disobeyed(event)) return let_go(Fault::disobeyed, event);
    if (missing_part_ > policy_.missing_part) return let_go(Fault::losses, event);
  }
  if (engaged() && missing_ > policy_.hold_periods) {
    state_ = State::fading;
    fade_from(force_);
  } else if (state_ == State::fading && event.measurement != nullptr &&
             event.measurement->seq - law_seq_ <= Law::longest_gap) {
    pace_.lose_track();
    pace_.let_go(base_);
    obedience_.lose_track();
    p_ = smooth_step_inverse(smooth_step(p_) * smooth_step(q_));
    excited_before_ *= smooth_step(q_);
    state_ = wanted_ ? State::ramp_in : State::ramp_out;
  }
}

bool Supervisor::disobeyed(const Event& event) noexcept {
  if (event.measurement == nullptr) return false;
  if (unheard_ > 0) {
    obedience_.lose_track();
    return false;
  }
  obedience_.hear(gap_ + event.n_elapsed, event.measurement->applied);
  if (!obedience_.is_broken()) return false;
  watch_.began_with(obedience_.leg());
  return true;
}

void Supervisor::fade_from(const VectorXd& force) noexcept {
  base_ = force;
  step_.setZero();
  q_ = base_.isZero(0) ? 0 : 1;
}

// Commands did not reach the amplifiers, or another has served them: what they do until they have
// let go is their own. To go on from what a read-back says would command its lies.
void Supervisor::fall_silent(std::int64_t n_elapsed) noexcept {
  held_ = held_ || !limits_.last().isZero(0);
  limits_.let_go();
  base_.setZero();
  step_.setZero();
  q_ = 0;
  quiet_ = let_go_ + n_elapsed;
}

// Nothing is sent. A loop that held nothing need not wait for amplifiers that hold nothing either,
// and while they let go of something no sensor shows its offset.
void Supervisor::listen(const Event& event) noexcept {
  quiet_ = std::max<std::int64_t>(0, quiet_ - event.n_elapsed);
  if (event.measurement != nullptr) {
    const bool acts = (event.measurement->applied.array().abs() > pace_.free().array()).any();
    const std::int64_t n_listened = let_go_ - quiet_;
    if (!acts && !held_ && n_listened >= std::llround(quiet_s / sample_time_)) quiet_ = 0;
    if (acts && state_ == State::arming) restart_arming();
  }
  held_ = held_ && quiet_ > 0;
}

// A fade that goes on already is not begun anew: it would never end.
void Supervisor::let_go(Fault fault, const Event& event) noexcept {
  const bool fades = state_ == State::fading;
  ++n_faults_;
  fault_ = fault;
  state_ = State::fault;
  p_ = 0;
  if (fault == Fault::suspended || fault == Fault::unheard) {
    fall_silent(event.n_elapsed);
  } else if (!fades) {
    // What a loop that has run away commanded last is nothing to hold.
    const bool ran_away =
        fault == Fault::limited || fault == Fault::restless || fault == Fault::disobeyed;
    fade_from(force_);
    if (ran_away) {
      const VectorXd& steady = watch_.steady_force();
      step_ = base_ - steady;
      base_ = steady;
    }
  }
  if (is_passing(fault)) {
    passing_fault_ = true;
  } else {
    latched_ = true;
    wanted_ = false;
  }
}

void Supervisor::latch(Fault fault) noexcept {
  ++n_faults_;
  fault_ = fault;
  state_ = State::fault;
  latched_ = true;
  wanted_ = false;
}

void Supervisor::begin_latched(Fault fault, Index leg) noexcept {
  latch(fault);
  watch_.began_with(leg);
  n_faults_ = 0;  // it was counted when it happened
}

// Out of a passing fault, once the force is gone and measurements are there again.
void Supervisor::come_back(const Event& event) noexcept {
  if (latched_ || q_ > 0 || quiet_ > 0 || event.measurement == nullptr) return;
  if (wanted_ && rejoins_ + 1 > static_cast<double>(policy_.rejoins_a_minute)) {
    latched_ = true;
    wanted_ = false;
    return;
  }
  state_ = State::idle;
}

void Supervisor::restart_arming() noexcept {
  arming_.restart();
  pace_.restart();
  obedience_.restart();
}

void Supervisor::arm(const Event& event) noexcept {
  if (event.n_elapsed - 1 > policy_.hold_periods || missing_ > policy_.hold_periods) {
    restart_arming();
  }
  const Fault broken = fault_of(last_defect_);
  if (!is_passing(broken) &&
      static_cast<double>(missing_) * sample_time_ > policy_.arming_s + policy_.fade_s) {
    return latch(broken);
  }
  if (event.measurement == nullptr) return;
  arming_.add(event.measurement->sigma);
  pace_.listen(event.measurement->seq, event.measurement->sigma);
  obedience_.listen(event.measurement->applied);
  if (!arming_.complete() || missing_part_ > policy_.missing_part || q_ > 0) return;
  if (quiet_ > 0) return;
  // Held by somebody, or a read-back that lies: a person should look.
  if (limits_.is_beyond(event.measurement->applied)) return latch(Fault::out_of_range);
  const Fault found = arming_.judge(offset_, u_);
  if (found != Fault::none) return latch(found);
  pace_.begin(u_);
  pace_.hear_as(law_);
  watch_.restart();
  obedience_.begin();
  if (const Index leg = pace_.noisy(); leg >= 0) {
    watch_.began_with(leg);
    return latch(Fault::noisy);
  }
  asked_.setZero();
  asked_before_.setZero();
  excited_before_.setZero();
  ramp_.setZero();
  n_samples_ = 1;
  met_limit_ = false;
  law_.reset();
  law_ran_ = false;
  unheard_ = 0;
  p_ = 0;
  if (passing_fault_) {
    ++n_rejoins_;
    rejoins_ += 1;
    passing_fault_ = false;
  }
  state_ = State::ramp_in;
}

// In every state: when the loop takes hold, the feed-forward knows what the floor did before.
void Supervisor::hear_floor(const Event& event) noexcept {
  const std::int64_t n = floor_seq_ < 0 ? 1 : event.measurement->seq - floor_seq_;
  floor_seq_ = event.measurement->seq;
  const bool was_believed = floor_watch_.believed();
  const Measurement& now = *event.measurement;
  const Index liar = floor_evidence_.hear(n, now.floor, now.sigma, now.applied);
  floor_watch_.hear(n, now.floor, liar, floor_evidence_.judges());
  law_.hear_floor(n, now.floor, floor_watch_.share(), floor_watch_.believed());
  const bool believed = floor_watch_.believed();
  if (!was_believed && believed) pace_.hear_as(law_);
  pace_.floor(now.floor, !believed && floor_watch_.broken() >= 0);
}

void Supervisor::run_law(const Event& event) noexcept {
  const Measurement& now = *event.measurement;
  n_samples_ = law_ran_ ? now.seq - law_seq_ : 1;
  law_ran_ = true;
  law_seq_ = now.seq;
  sigma_ = now.sigma - offset_;
  law_.step_over(n_samples_, sigma_, now.applied, u_);
  if (!u_.allFinite() || !law_.state().allFinite()) return let_go(Fault::law_not_finite, event);
  const double gain_before = smooth_step(p_);
  move_gain(event.n_elapsed);
  if (!engaged()) return;
  const double gain = smooth_step(p_);
  if (excitation_.open_loop()) u_.setZero();
  force_ = gain * u_;
  ramp_ = (gain - gain_before) * u_;
  if (excitation_.any()) excite(now.seq, gain);
  asked_ = force_;
  if (unheard_ > 0) pace_.lose_track();
  pace_.expect(n_samples_, gain, obedience_.acts(), floor_watch_.share());
}

void Supervisor::excite(std::int64_t seq, double gain) noexcept {
  if (state_ == State::active) excitation_.begin(seq);
  excited_ = gain * excitation_.at(seq);
  ramp_ += excited_ - excited_before_;
  excited_before_ = excited_;
  force_ += excited_;
  allowed_ = gain * excitation_.reach();
  pace_.excite(allowed_);
}

void Supervisor::move_gain(std::int64_t n_elapsed) noexcept {
  const double passed = static_cast<double>(n_elapsed) * sample_time_;
  if (state_ == State::ramp_in) {
    p_ = std::min(1.0, p_ + passed / policy_.ramp_in_s);
    if (p_ == 1) state_ = State::active;
  } else if (state_ == State::ramp_out) {
    p_ = std::max(0.0, p_ - passed / policy_.ramp_out_s);
    if (p_ > 0) return;
    state_ = State::idle;
    // The last gate may have held it back by more than a step.
    const bool held = (limits_.last().array().abs() > pace_.most(1).array()).any();
    if (!held) force_.setZero();
    fade_from(held ? limits_.last() : force_);
    force_ = base_;
  }
}

}  // namespace stillframe::controller
