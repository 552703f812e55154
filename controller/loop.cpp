#include "controller/loop.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

constexpr auto relaxed = std::memory_order_relaxed;
constexpr double checkpoint_s = 0.1, telemetry_s = 1, after_fault_s = 0.5;
// In which an amplifier lets go of a force that it holds (docs/hardware.md).
constexpr double amplifiers_s = 1.5;
constexpr std::int64_t amplifiers_samples = 15;
constexpr int most_taken = 4096;  // measurements a period
constexpr std::int64_t longest_sleep_ns = 50'000'000;

LoopRecord record_of(Eigen::Index m, Eigen::Index p, Eigen::Index q) {
  LoopRecord record;
  record.measurement = measurement_of(m, p, q);
  record.command = command_of(m);
  record.excitation = Eigen::VectorXd::Zero(m);
  return record;
}

LoopCheckpoint checkpoint_of(const Supervisor& supervisor) {
  return {.period = 0, .memory = std::vector<double>(supervisor.memory_size())};
}

std::int64_t samples(double seconds, double rate_hz) {
  return std::max<std::int64_t>(1, std::llround(seconds * rate_hz));
}

std::size_t places(double seconds, double rate_hz) {
  return static_cast<std::size_t>(samples(seconds, rate_hz));
}

void add(std::atomic<std::int64_t>& counter, std::int64_t n) noexcept {
  counter.store(counter.load(relaxed) + n, relaxed);
}

void raise(std::atomic<std::int64_t>& worst, std::int64_t value) noexcept {
  if (value > worst.load(relaxed)) worst.store(value, relaxed);
}

std::int64_t page_faults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace

Loop::Loop(Io& io, const Supervisor& supervisor, const Policy& policy, const LoopSetting& setting)
    : io_(io),
      supervisor_(supervisor),
      clock_(setting.start_ns, setting.sample_rate_hz, setting.pacing, setting.start_doubt_ns),
      screen_(policy, setting.sample_rate_hz),
      deadlines_(setting.start_ns, setting.sample_rate_hz, setting.phase),
      disable_after_(samples(amplifiers_s, setting.sample_rate_hz) + amplifiers_samples),
      checkpoint_every_(samples(checkpoint_s, setting.sample_rate_hz)),
      last_answered_(setting.first_seq - 1),
      page_faults_every_(samples(1, setting.sample_rate_hz)),
      incoming_(measurement_of(supervisor.n_legs(), setting.n_floor, setting.n_frame)),
      newest_(incoming_),
      record_(record_of(supervisor.n_legs(), setting.n_floor, setting.n_frame)),
      checkpoint_(checkpoint_of(supervisor)),
      records_(places(telemetry_s, setting.sample_rate_hz), record_),
      checkpoints_(places(telemetry_s / checkpoint_s, 1) + 1, checkpoint_),
      flight_(std::make_shared<FlightRecorder>(
          places(policy.record_s, setting.sample_rate_hz),
          places(policy.record_s, setting.sample_rate_hz) /
                  places(checkpoint_s, setting.sample_rate_hz) +
              1,
          samples(policy.fade_s + after_fault_s, setting.sample_rate_hz), record_, checkpoint_)) {
  if (setting.now_ns > deadlines_.next_ns()) deadlines_.wake_up(setting.now_ns);
  counters_.state = supervisor_.state();
  counters_.fault = supervisor_.fault();
  counters_.latched = supervisor_.latched();
}

void Loop::period(std::int64_t now_ns) noexcept {
  record_.deadline_ns = deadlines_.next_ns();
  record_.wake_up_ns = now_ns;
  const Deadlines::WakeUp wake_up = deadlines_.wake_up(now_ns);
  record_.n_elapsed = 1 + wake_up.n_skipped;
  period_ += record_.n_elapsed;
  record_.period = period_;
  give_checkpoint();

  record_.defect = take_newest(now_ns);
  const RequestSlot::Asked asked = requests_.take();
  record_.request = asked.request;
  const bool have = record_.defect == Defect::none;
  record_.sent = supervisor_.step({.n_elapsed = record_.n_elapsed,
                                   .measurement = have ? &record_.measurement : nullptr,
                                   .defect = record_.defect,
                                   .request = record_.request},
                                  record_.command);
  if (record_.sent) record_.excitation = supervisor_.excited();
  record_.computed_ns = monotonic_ns();
  io_.beat();
  enable();
  if (record_.sent) io_.send(record_.command);
  record_.published_ns = monotonic_ns();

  times_.wake_up.add(wake_up.past_deadline_ns);
  times_.compute.add(record_.computed_ns - now_ns);
  if (record_.sent) times_.publish.add(record_.published_ns - record_.computed_ns);
  if (have) times_.receive.add(newest_.received_ns - clock_.local_ns(newest_.time_ns));
  add(counters_.n_late, wake_up.n_skipped);
  raise(counters_.worst_wake_up_ns, wake_up.past_deadline_ns);
  count(now_ns);
  requests_.done(asked);
  give_record();
}

// A force that was left to the amplifiers still acts when nothing is commanded: they are switched
// off once they have let go of it.
void Loop::enable() noexcept {
  idle_ = supervisor_.driving() ? 0 : idle_ + record_.n_elapsed;
  const bool on = idle_ == 0 || (enabled_ && idle_ < disable_after_);
  if (on != enabled_) io_.enable(on);
  enabled_ = on;
}

void Loop::bound_clock() noexcept {
  const std::int64_t earliest = earliest_start_ns_.load(relaxed);
  const std::int64_t latest = latest_start_ns_.load(relaxed);
  earliest <= latest ? clock_.bound(earliest, latest) : clock_.unbound();
}

// Bounded, so that a flood costs lateness that is counted, and not a loop that never answers again.
Defect Loop::take_newest(std::int64_t now_ns) noexcept {
  bool any = false;
  const bool began = clock_.locked();
  const bool waits = clock_.disciplined() && !began;
  bound_clock();
  for (int n = 0; n < most_taken && io_.receive(incoming_); ++n) {
    // What has waited since before the loop began is nobody's to answer: the newest is the first.
    if (waits) {
      while (n < most_taken && io_.receive(incoming_)) ++n;
    }
    clock_.see(incoming_);
    if (!screen_.is_new(incoming_, clock_.age(incoming_, now_ns))) {
      add(counters_.n_duplicate, 1);
      continue;
    }
    any = true;
    std::swap(incoming_, newest_);
  }
  if (clock_.disciplined() && clock_.locked()) {
    // Where numbers stay, it is the line that moves, by as much as the plant's clock stood still.
    const bool moved =
        clock_.keeps_numbers() && clock_.n_locks() != counters_.n_locks.load(relaxed);
    if (!began || moved) deadlines_.begin(clock_.reference_ns(), clock_.reference(), now_ns);
    deadlines_.follow(clock_.reference_ns(), clock_.reference(), clock_.period_ns());
    counters_.n_locks.store(clock_.n_locks(), relaxed);
    counters_.n_held.store(clock_.n_held(), relaxed);
    counters_.drift.store(clock_.drift(), relaxed);
  }
  if (!any) return Defect::missing;
  const Defect defect = screen_.judge(newest_, clock_.age(newest_, now_ns));
  if (defect == Defect::none) record_.measurement = newest_;
  return defect;
}

void Loop::count(std::int64_t now_ns) noexcept {
  add(counters_.n_periods, 1);
  if (record_.defect == Defect::none) {
    add(counters_.n_answered, 1);
    add(counters_.n_lost, newest_.seq - last_answered_ - 1);
    last_answered_ = newest_.seq;
    if (!record_.sent) add(counters_.n_listened, 1);
  } else {
    add(counters_.n_missing, 1);
  }
  raise(counters_.worst_compute_ns, record_.computed_ns - now_ns);
  record_.state = supervisor_.state();
  record_.fault = supervisor_.fault();
  if (supervisor_.n_faults() > counters_.n_faults.load(relaxed)) flight_->trigger();
  counters_.n_faults.store(supervisor_.n_faults(), relaxed);
  counters_.n_rejoins.store(supervisor_.n_rejoins(), relaxed);
  counters_.n_saturated.store(supervisor_.n_saturated(), relaxed);
  counters_.fault.store(record_.fault, relaxed);
  counters_.broken_floor.store(supervisor_.broken_floor(), relaxed);
  counters_.first_leg.store(supervisor_.first_leg(), relaxed);
  counters_.latched.store(supervisor_.latched(), relaxed);
  counters_.driving.store(supervisor_.driving(), relaxed);
  if (record_.state == State::active) add(counters_.n_active, 1);
  counters_.state.store(record_.state, std::memory_order_release);
  counters_.woke_ns.store(now_ns, std::memory_order_release);
  if (--since_page_faults_ <= 0) {
    since_page_faults_ = page_faults_every_;
    const std::int64_t now = page_faults();
    if (page_faults_at_start_ < 0) page_faults_at_start_ = now;
    counters_.n_page_faults.store(now - page_faults_at_start_, relaxed);
  }
}

void Loop::give_checkpoint() noexcept {
  if (--since_checkpoint_ > 0) return;
  since_checkpoint_ = checkpoint_every_;
  checkpoint_.period = period_;
  supervisor_.save(checkpoint_.memory);
  flight_->add(checkpoint_);
  if (!checkpoints_.give(checkpoint_)) add(counters_.n_records_dropped, 1);
}

void Loop::give_record() noexcept {
  flight_->add(record_);
  if (!records_.give(record_)) add(counters_.n_records_dropped, 1);
}

void run_periodic(Loop& loop, const std::atomic<bool>& stop) noexcept {
  std::int64_t now = monotonic_ns();
  while (!stop.load(relaxed)) {
    // A run may begin an hour from now, or never.
    sleep_until(std::min(loop.next_ns(), now + longest_sleep_ns));
    now = monotonic_ns();
    if (now >= loop.next_ns()) loop.period(now);
  }
  loop.finish();
}

}  // namespace stillframe::controller
